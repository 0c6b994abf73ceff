//! `raystep trace`

mod crossed;
mod element;

use std::ops::ControlFlow;
use std::str::FromStr;

use clap::{ArgGroup, Args, ValueEnum};
use raystep_inspector::link::{Link, LinkRay};
use raystep_inspector::ray_text::GivenRay;
use raystep_inspector::runs::scene_hash;
use raystep_kernels::export::light_tree::LightTree;
use raystep_kernels::export::trace::{Rays, Trace, trace, trace_element};
use raystep_kernels::history::units::Units;
use raystep_kernels::options::Integrator;
use raystep_kernels::programs::photons::stored;
use raystep_kernels::{Pass, RaySource};
use serde::Serialize;

use crate::args::{QuietArgs, RunArgs, ViewArgs};
use crate::error::Error;
use crate::link::{LinkArgs, Wanted, link_of};
use crate::program_folder;
use crate::session::Session;
use crate::terminal::{Progress, print, say};
use crossed::Crossed;

/// Print the history of one ray, with the reason for every step
///
/// Prints one row for every pass that processed the ray, from the executor's streams: kernel, state, cell, tmax, item,
/// triangle tested, hit, and the reason. All values are those after the pass, except the state, which is shown before
/// and after if it changes; columns of CSV and fields of JSON say which in their names. t is a multiple of the ray's direction; a camera's rays have length 1 along the view axis, so
/// there t is depth. The table is in scene units. CSV and JSON have the streams' own numbers, in traced units; CSV has t
/// in scene units, too, and JSON the factors.
///
/// If rays go on from hits to lights, the table and JSON end with the pixel's light tree: what every ray ended in, what
/// light it brings or what occludes it, and what that adds to the pixel.
///
/// With --integrator photons, the rows of a pixel tell its search for photons: the cells of the map, how many photons are taken of
/// each, the radius and the estimate. --photon prints the history of a photon instead, from its light to its end.
///
/// For a folder with program.toml, --pixel names an element: for every pass, what it has changed, and the conditions that the
/// kernel came to, with their lines.
///
/// Only this ray is traced, unless --all-rays is used. Without it, the total number of passes is not known, and the final
/// shading pass is shown as 'last'.
#[derive(Args, Debug)]
#[command(group = ArgGroup::new("which").args(["pixel", "ray", "photon"]), after_help = "\
Examples:
  raystep trace cornell-box --pixel 256,256
  raystep trace cornell-box --pixel 256,256 --numerics paper --format csv > ray.csv
  raystep trace teapot --ray 0,0,5,0,0,-1
  raystep trace whitted --integrator photons --photons 5000 --photon 1234
  raystep trace teapot --ray 0,0,5,0,0,-1 --all-hits
  raystep trace my-program --pixel 12,40
  raystep trace teapot --ray 0,0,0x40a00000,0,0,0xbf800000 --format json
  raystep trace --link \"raystep:1?scene=teapot&accelerator=bvh&pixel=256,256\"")]
pub(crate) struct TraceArgs {
    #[command(flatten)]
    scene: LinkArgs,
    /// Pixel of the ray, counted from 0 at the top left
    #[arg(long, value_name = "X,Y", allow_hyphen_values = true)]
    pixel: Option<Pixel>,
    /// A single ray in the scene file's coordinates: origin and direction, decimal or as the bits of an f32 in hex
    #[arg(long, value_name = "OX,OY,OZ,DX,DY,DZ", allow_hyphen_values = true)]
    ray: Option<GivenRay>,
    /// Photon, counted from 0, with --integrator photons
    #[arg(long, value_name = "N")]
    photon: Option<u32>,
    /// Also trace the rays of all other pixels, as 'render' does, to show the number of passes
    ///
    /// Without it, only this ray is traced; its rows are the same, bit for bit. With --schedule first, several samples per
    /// pixel, rays to lights or photons, a ray's passes depend on others, so all are traced.
    #[arg(long)]
    all_rays: bool,
    /// Also list every surface that the ray, or the pixel's first ray, crosses, in the order of exact t
    #[arg(long)]
    all_hits: bool,
    /// A readable table, or data
    #[arg(long, value_enum, default_value_t = Format::Table)]
    format: Format,
    /// Print a link to this trace on stderr, for 'trace' and for the inspector
    #[arg(long)]
    print_link: bool,
    #[command(flatten)]
    quiet: QuietArgs,
    #[command(flatten)]
    view: ViewArgs,
    #[command(flatten)]
    run: RunArgs,
}

/// A history as JSON.
#[derive(Serialize)]
struct Traced<'a> {
    #[serde(flatten)]
    history: &'a Trace,
    #[serde(skip_serializing_if = "Option::is_none")]
    light_tree: Option<LightTree>,
    #[serde(skip_serializing_if = "Option::is_none")]
    all_hits: Option<Vec<Crossed>>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Format {
    Table,
    Json,
    Csv,
}

/// `--pixel`
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Pixel {
    /// Column.
    pub(crate) x: u32,
    /// Row, from the top.
    pub(crate) y: u32,
}

impl FromStr for Pixel {
    type Err = &'static str;

    fn from_str(value: &str) -> Result<Self, Self::Err> {
        const WRONG: &str = "expected two integers separated by a comma, such as 256,256";
        let (x, y) = value.split_once(',').ok_or(WRONG)?;
        Ok(Self { x: x.trim().parse().map_err(|_| WRONG)?, y: y.trim().parse().map_err(|_| WRONG)? })
    }
}

/// Why `--all-rays` is implied.
const NOT_ALONE: &str = "a ray's passes depend on the other rays here (--schedule first, several samples per \
                         pixel, shadow rays, or photons), so all are traced";

/// The photon to follow, in a run that has photons.
fn photon_of(wanted: &Wanted, photon: u32) -> Result<u32, Error> {
    match (wanted.run.tracing.values.integrator, wanted.ray) {
        (Integrator::Photons, None) => Ok(photon),
        (Integrator::Photons, Some(_)) => {
            Err(Error::usage("--link has a ray, and --photon names a photon: omit one of them"))
        }
        _ => Err(Error::usage("--photon names a photon of --integrator photons: add it")),
    }
}

pub(crate) fn run(args: TraceArgs) -> Result<(), Error> {
    let asked = match (args.pixel, args.ray) {
        (Some(Pixel { x, y }), _) => Some(LinkRay::Pixel([x, y])),
        (None, Some(ray)) => Some(LinkRay::Given(ray)),
        (None, None) => None,
    };
    if let Some(path) = args.scene.scene.as_ref().filter(|path| program_folder::find(path).is_some()) {
        if args.all_hits {
            return Err(Error::usage("--all-hits: a program of one's own has no rays"));
        }
        let Some(pixel) = args.pixel else {
            return Err(Error::usage("--pixel X,Y names the element of a program of one's own"));
        };
        return element::run(path, pixel, args.format, &args.view, &args.run, &args.scene.read, &args.quiet);
    }
    let mut wanted = args.scene.wanted(args.view, args.run)?;
    let photon = args.photon.map(|index| photon_of(&wanted, index)).transpose()?;
    if photon.is_some() && args.print_link {
        return Err(Error::usage("--print-link: a link has a ray, but no photon"));
    }
    if args.all_hits && (photon.is_some() || args.format == Format::Csv) {
        let why = if photon.is_some() {
            "a photon's way is not straight: name a ray"
        } else {
            "CSV has the passes only; use json"
        };
        return Err(Error::usage(format!("--all-hits: {why}")));
    }
    let ray = match (asked, wanted.ray) {
        (Some(_), Some(_)) => {
            return Err(Error::usage("--link has a ray, and so does --pixel or --ray: omit one of them"));
        }
        (None, None) if photon.is_none() => {
            return Err(Error::usage("missing ray: use --pixel X,Y, --ray OX,OY,OZ,DX,DY,DZ or --photon N"));
        }
        (asked, linked) => asked.or(linked),
    };
    wanted.ray = ray;
    let size = wanted.view.size;
    let [x, y] = if let Some(LinkRay::Pixel(pixel)) = ray { pixel } else { [0, 0] };
    if x >= size.width || y >= size.height {
        return Err(Error::usage(format!(
            "--pixel {x},{y}: the image has pixels 0,0 to {},{}; --size enlarges it",
            size.width - 1,
            size.height - 1
        )));
    }
    if !wanted.run.tracing.values.schedule.is_stepped() {
        return Err(Error::usage(
            "--schedule fused traces a ray in one pass, so there are no steps to follow; use first, second or \
             compact",
        ));
    }
    if matches!(ray, Some(LinkRay::Given(_))) && wanted.view.samples.values.samples.count > 1 {
        return Err(Error::usage("--spp applies to pixels, but --ray is a single ray: omit one of them"));
    }
    if matches!(ray, Some(LinkRay::Given(_))) && args.all_rays {
        return Err(Error::usage("--all-rays applies to pixels, but --ray is a single ray: omit one of them"));
    }
    let mut link = args.print_link.then(|| link_of(&wanted)).transpose()?;
    let progress = Progress::new(args.quiet.quiet);
    let session = Session::new(&wanted.scene, &wanted.view, &wanted.run, &progress, |scene, options| {
        options.keep_passes = false;
        if let Some(LinkRay::Given(ray)) = ray {
            options.rays = RaySource::Given(vec![ray.in_scene(scene)]);
        }
    })?;
    if link.is_some() || wanted.scene_hash.is_some() {
        let hash = scene_hash(&session.scene);
        if wanted.scene_hash.is_some_and(|expected| expected != hash) {
            let name = &session.scene.name;
            progress.say(format_args!("note: {name} is not the scene that the link was made with: results may differ"));
        }
        link = link.map(|link| Link { scene_hash: Some(hash), ..link });
    }
    let mut running = session.start(&progress)?;
    progress.stage("tracing");
    if photon.is_none() && !args.all_rays && running.renderer.plan().rays > 1 && !running.renderer.can_go_alone() {
        progress.say(format_args!("note: {NOT_ALONE}"));
    }
    let rays = if args.all_rays { Rays::All } else { Rays::One };
    let told = |pass: &Pass| {
        progress.pass(pass.index);
        ControlFlow::Continue(())
    };
    let history = match photon {
        Some(index) => running.chosen.wait(trace_element(&mut running.renderer, stored::SET, index, told))?,
        None => running.chosen.wait(trace(&mut running.renderer, x, y, rays, told))?,
    };
    progress.finish();
    if let Some(link) = link {
        say(format_args!("open in the inspector: raystep inspect --link \"{link}\""));
    }
    let all_hits = match args.all_hits {
        true => Some(running.chosen.wait(crossed::crossed(&running.scene, &history))?),
        false => None,
    };
    let plan = running.renderer.plan();
    let light_tree = LightTree::of(&history.rows, plan.program, running.renderer.data());
    match args.format {
        Format::Table => {
            let tree = light_tree.map_or_else(String::new, |tree| format!("\n{}", tree.table(&history, Units::Scene)));
            let crossed = all_hits.map_or_else(String::new, |all| crossed::table(&all));
            print(&(history.table(Units::Scene) + &tree + &crossed))
        }
        Format::Json => print(&super::json_text(&Traced { history: &history, light_tree, all_hits })?),
        Format::Csv => {
            let mut text = Vec::new();
            history.write_csv(&mut text).map_err(|e| Error::failed(format!("cannot write as CSV: {e}")))?;
            print(&String::from_utf8_lossy(&text))
        }
    }
}
