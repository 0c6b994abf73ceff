//! `--link`: scene, view and tracing options in one line, replacing the corresponding options.

use std::path::PathBuf;

use clap::Args;
use raystep_inspector::link::{Link, LinkCamera, LinkDevice, LinkRay};
use raystep_lab::{Hash, Size};

use crate::args::choices::{ChoiceArgs, with_linked};
use crate::args::kernel::KernelArgs;
use crate::args::{CameraArgs, DeviceArgs, DeviceKind, ReadArgs, RunArgs, SceneArgs, Vector, ViewArgs, counted};
use crate::error::Error;

/// A scene's file, or a link.
#[derive(Args, Debug)]
pub(crate) struct LinkArgs {
    /// The scene: a file that ends in .gltf, .glb, .obj, .ply or .stl, or a name, such as cornell-box; or a program: a folder
    /// with program.toml, or FOLDER@SCENE
    pub(crate) scene: Option<PathBuf>,
    /// Index of the scene in a file with several, counted from 0 [default: the file's default scene]
    #[arg(long, value_name = "N", value_parser = counted, allow_negative_numbers = true, help_heading = "Scene and view")]
    pub(crate) scene_index: Option<usize>,
    #[command(flatten)]
    pub(crate) read: ReadArgs,
    /// Link with the scene and the options that it sets
    ///
    /// Use double quotes around it. --device and --adapter may be added if the link has neither; a link never sets the
    /// limits for reading a scene.
    #[arg(
        long,
        value_name = "LINK",
        conflicts_with_all = with_linked(&["scene", "scene_index", "size", "camera", "eye", "look_at", "up", "fov"])
    )]
    pub(crate) link: Option<String>,
}

/// The request, from options or from a link.
pub(crate) struct Wanted {
    pub(crate) scene: SceneArgs,
    pub(crate) view: ViewArgs,
    pub(crate) run: RunArgs,
    /// The ray that a link contains.
    pub(crate) ray: Option<LinkRay>,
    /// The hash of the scene that a link was made with.
    pub(crate) scene_hash: Option<Hash>,
}

impl LinkArgs {
    /// The request: from the link if there is one, otherwise from the options. Without `--steps-per-pass`, both take
    /// one step per pass.
    pub(crate) fn wanted(self, view: ViewArgs, mut run: RunArgs) -> Result<Wanted, Error> {
        if let Some(text) = self.link {
            let link = text.parse().map_err(|e| Error::usage(format!("--link: {e}")))?;
            return from_link(link, self.read, run.kernels, run.device);
        }
        let scene =
            self.scene.ok_or_else(|| Error::usage("missing scene: name its file, or use --link LINK (see --help)"))?;
        run.tracing.step_by_step();
        let scene = SceneArgs { scene, scene_index: self.scene_index, read: self.read };
        Ok(Wanted { scene, view, run, ray: None, scene_hash: None })
    }
}

fn from_link(link: Link, read: ReadArgs, kernels: KernelArgs, device: DeviceArgs) -> Result<Wanted, Error> {
    let scene = link.scene.ok_or_else(|| Error::usage("--link: it has no scene: add scene=FILE"))?;
    let is_named = link.device != LinkDevice::Auto || link.adapter.is_some();
    if is_named && (device.device != DeviceKind::Auto || device.adapter.is_some()) {
        return Err(Error::usage("--link has a device, and so does an option: omit one of them"));
    }
    let linked = DeviceArgs {
        device: match link.device {
            LinkDevice::Auto => DeviceKind::Auto,
            LinkDevice::Gpu => DeviceKind::Gpu,
            LinkDevice::Cpu => DeviceKind::Cpu,
        },
        adapter: link.adapter,
    };
    let no_camera = CameraArgs { camera: None, eye: None, look_at: None, up: None, fov: None };
    let [width, height] = link.size;
    Ok(Wanted {
        scene: SceneArgs { scene: scene.into(), scene_index: link.scene_index, read },
        view: ViewArgs {
            size: Size { width, height },
            camera: match link.camera {
                LinkCamera::Default => no_camera,
                LinkCamera::Index(n) => CameraArgs { camera: Some(n), ..no_camera },
                LinkCamera::Placed { eye, look_at, up, fov_deg } => CameraArgs {
                    camera: None,
                    eye: Some(Vector(eye)),
                    look_at: Some(Vector(look_at)),
                    up: Some(Vector(up)),
                    fov: Some(fov_deg),
                },
            },
            samples: ChoiceArgs::of(link.choices),
        },
        run: RunArgs { tracing: ChoiceArgs::of(link.choices), kernels, device: if is_named { linked } else { device } },
        ray: link.ray,
        scene_hash: link.scene_hash,
    })
}

/// The link for these options: the inverse of [`LinkArgs::wanted`].
pub(crate) fn link_of(wanted: &Wanted) -> Result<Link, Error> {
    let Wanted { scene, view, run, ray, scene_hash } = wanted;
    let path = scene.scene.to_str();
    let path = path.ok_or_else(|| Error::failed("the scene's name is not UTF-8, so a link cannot contain it"))?;
    let CameraArgs { camera, eye, look_at, up, fov } = view.camera;
    Ok(Link {
        scene: Some(path.into()),
        scene_index: scene.scene_index,
        scene_hash: *scene_hash,
        camera: match (camera, eye, look_at) {
            (_, Some(Vector(eye)), Some(Vector(look_at))) => LinkCamera::Placed {
                eye,
                look_at,
                up: up.map_or(LinkCamera::UP, |v| v.0),
                fov_deg: fov.unwrap_or(LinkCamera::FOV_DEG),
            },
            (Some(n), ..) => LinkCamera::Index(n),
            _ => LinkCamera::Default,
        },
        size: [view.size.width, view.size.height],
        choices: run.choices(view),
        device: match run.device.device {
            DeviceKind::Auto | DeviceKind::GpuFirst => LinkDevice::Auto,
            DeviceKind::Gpu => LinkDevice::Gpu,
            DeviceKind::Cpu => LinkDevice::Cpu,
        },
        adapter: run.device.adapter.clone(),
        ray: *ray,
        ..Link::default()
    })
}
