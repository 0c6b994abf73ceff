//! The command line.

use std::path::PathBuf;

use glam::DVec3;

pub(crate) const USAGE: &str = "performance measure --adapter gpu|software|cpu -o DIR
            [--mesh NAME=FILE[:EYE:LOOK_AT:FOV]]... [--only SECTION,...] [--quick]
performance page DIR...

SECTION is one of paper, resolution, steps, bytes, tdelta, meshes, triangles. Points are X,Y,Z; FOV is vertical,
in degrees. FILE is glTF, GLB, OBJ, PLY or STL; without a view, its first camera, or one that frames it.";

/// Kind of device.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum AdapterKind {
    /// A real GPU.
    Gpu,
    /// Mesa's software Vulkan.
    Software,
    /// The twins (CPU reference kernels).
    Cpu,
}

/// A mesh to load.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct MeshArg {
    pub(crate) name: String,
    pub(crate) file: PathBuf,
    /// Eye, look-at point, vertical field of view in radians.
    pub(crate) view: Option<(DVec3, DVec3, f64)>,
}

/// Arguments of `measure`.
#[derive(Clone, Debug)]
pub(crate) struct MeasureArgs {
    pub(crate) adapter: AdapterKind,
    pub(crate) output: PathBuf,
    pub(crate) meshes: Vec<MeshArg>,
    /// Sections to measure; empty means all.
    pub(crate) only: Vec<String>,
    pub(crate) quick: bool,
    /// The arguments as given, for the record.
    pub(crate) text: String,
}

pub(crate) enum Command {
    Measure(MeasureArgs),
    Page(Vec<PathBuf>),
}

impl Command {
    pub(crate) fn parse(args: impl Iterator<Item = String>) -> Result<Self, String> {
        let args: Vec<String> = args.collect();
        match args.split_first() {
            Some((name, rest)) if name == "measure" => measure(rest).map(Self::Measure),
            Some((name, rest)) if name == "page" && !rest.is_empty() => {
                Ok(Self::Page(rest.iter().map(PathBuf::from).collect()))
            }
            Some((name, _)) if name == "page" => Err("page wants the folders that measure has written".into()),
            Some((name, _)) => Err(format!("{name:?} is not one of measure, page")),
            None => Err("nothing to do".into()),
        }
    }
}

fn measure(args: &[String]) -> Result<MeasureArgs, String> {
    let (mut adapter, mut output, mut meshes, mut only, mut quick) = (None, None, Vec::new(), Vec::new(), false);
    let mut rest = args.iter();
    while let Some(name) = rest.next() {
        let mut value = || rest.next().ok_or_else(|| format!("{name} wants a value"));
        match name.as_str() {
            "--adapter" => {
                adapter = Some(match value()?.as_str() {
                    "gpu" => AdapterKind::Gpu,
                    "software" => AdapterKind::Software,
                    "cpu" => AdapterKind::Cpu,
                    other => return Err(format!("--adapter: {other:?} is not one of gpu, software, cpu")),
                });
            }
            "-o" => output = Some(PathBuf::from(value()?)),
            "--mesh" => meshes.push(mesh(value()?)?),
            "--only" => only.extend(value()?.split(',').map(str::to_owned)),
            "--quick" => quick = true,
            other => return Err(format!("{other:?} is not an option of measure")),
        }
    }
    let known = |section: &&String| !crate::sections::NAMES.contains(&section.as_str());
    if let Some(unknown) = only.iter().find(known) {
        return Err(format!("--only: {unknown:?} is not one of {}", crate::sections::NAMES.join(", ")));
    }
    Ok(MeasureArgs {
        adapter: adapter.ok_or("--adapter is missing")?,
        output: output.ok_or("-o is missing")?,
        meshes,
        only,
        quick,
        text: args.join(" "),
    })
}

fn mesh(text: &str) -> Result<MeshArg, String> {
    let wrong = || format!("--mesh: {text:?} is not NAME=FILE or NAME=FILE:EYE:LOOK_AT:FOV");
    let (name, rest) = text.split_once('=').ok_or_else(wrong)?;
    // Split from the right: file names may contain colons.
    let parts: Vec<&str> = rest.rsplitn(4, ':').collect();
    let view = match parts[..] {
        [fov, look_at, eye, _] => point(eye).zip(point(look_at)).zip(fov.parse::<f64>().ok()),
        _ => None,
    };
    let (file, view) = match view {
        Some(((eye, look_at), fov)) => (parts[3], Some((eye, look_at, fov.to_radians()))),
        None => (rest, None),
    };
    Ok(MeshArg { name: name.into(), file: file.into(), view })
}

fn point(text: &str) -> Option<DVec3> {
    let numbers: Vec<f64> = text.split(',').map(str::parse).collect::<Result<_, _>>().ok()?;
    <[f64; 3]>::try_from(numbers).ok().map(DVec3::from)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_mesh_may_have_a_view_and_a_colon_in_its_name() {
        let view = Some((DVec3::new(1.0, -2.0, 0.5), DVec3::ZERO, 90f64.to_radians()));
        let plain = mesh("a=c:/x y.glb").expect("a mesh");
        assert_eq!((plain.file, plain.view), (PathBuf::from("c:/x y.glb"), None));
        let viewed = mesh("a=c:/x.glb:1,-2,.5:0,0,0:90").expect("a mesh");
        assert_eq!((viewed.name, viewed.file, viewed.view), ("a".into(), PathBuf::from("c:/x.glb"), view));
        assert!(mesh("x.glb").is_err());
    }
}
