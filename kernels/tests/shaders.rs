//! Every kernel composes, validates and binds only what the tables know, in every combination of options that a run can
//! ask for; the host's uniforms have the WGSL's layout.

use std::collections::HashSet;
use std::fs;
use std::mem::{offset_of, size_of};
use std::path::{Path, PathBuf};

use raystep_kernels::fragment::{self, DrawnKernel};
use raystep_kernels::options::Integrator;
use raystep_kernels::options::features::Features;
use raystep_kernels::options::mapping::{Fragment, Until};
use raystep_kernels::program::live;
use raystep_kernels::programs::closest_hit::{PROGRAM, kernels, streams};
use raystep_kernels::programs::grid_build;
use raystep_kernels::shader::{Binding, Resource, ShaderError, Variant};
use raystep_kernels::shared::camera::Camera;
use raystep_kernels::shared::grid_walk::Grid;
use raystep_kernels::shared::samples::Sampling;
use raystep_kernels::shared::scene::SceneInfo;
use raystep_kernels::shared::shading::{Light, Material, Shading};
use raystep_kernels::shared::texture::Texture;
use raystep_kernels::structures::bvh::BvhNode;
use raystep_kernels::tables::kernel::Role;
use raystep_kernels::{Accelerator, Kernel, Limits, Options, Plan, RaySource, ScheduleKind};
use raystep_scenes::generate;

/// All features off, then each alone, then all on, for every structure, robust and paper.
fn feature_sets() -> Vec<Features> {
    let mut sets = Vec::new();
    let none = Features::default();
    let [grid, irregular, bvh] =
        [Features { grid: true, ..none }, Features { irregular: true, ..none }, Features { bvh: true, ..none }];
    let structures =
        [(true, grid), (true, irregular), (true, bvh), (true, none), (false, grid), (false, bvh), (false, none)];
    for (robust, structure) in structures {
        let base = Features { robust, watertight: robust, in_cell: structure.grid && !robust, ..structure };
        sets.push(base);
        // One of the robust rules changed at a time.
        let without: [fn(&mut Features); 4] =
            [|f| f.watertight = false, |f| f.contracted = true, |f| f.drifting = f.grid, |f| f.in_cell = f.grid];
        for change in without.into_iter().filter(|_| robust) {
            for (live_lists, many_steps) in [(false, false), (true, true)] {
                let mut one = Features { live_lists, many_steps, counters: true, ..base };
                change(&mut one);
                sets.push(one);
                sets.push(waiting(one));
            }
        }
        let toggles: [fn(&mut Features); 23] = [
            // Empty-space skipping needs exact planes; the paper's rules have none.
            |f| f.skip = f.robust && f.grid,
            |f| f.ray_padding = f.bvh,
            |f| f.live_lists = true,
            |f| (f.live_lists, f.many_steps) = (true, true),
            |f| f.any_hit = f.robust,
            |f| f.intervals = true,
            |f| f.eye_rays = true,
            |f| f.clip = true,
            |f| f.perspective = true,
            |f| f.counters = true,
            |f| f.normals = true,
            |f| f.textures = true,
            |f| f.vertex_colors = true,
            |f| f.many_materials = true,
            |f| f.emissive = true,
            |f| f.double_sided = true,
            |f| f.many_lights = true,
            |f| f.directional_lights = true,
            |f| f.spot_lights = true,
            |f| f.samples = true,
            |f| (f.samples, f.sobol) = (true, true),
            |f| (f.resumes, f.turns) = (true, 100),
            |f| (f.many_lights, f.resumes_light, f.turns) = (true, true, 100),
        ];
        let mut all = base;
        for toggle in toggles {
            let mut one = base;
            toggle(&mut one);
            toggle(&mut all);
            sets.push(one);
            sets.push(waiting(one));
        }
        if structure.grid && !robust {
            // The other walk, alone, with each way to launch a kernel, and with everything.
            let alone = Features { dda: true, ..base };
            let counted = Features { counters: true, ..alone };
            let lists = Features { live_lists: true, ..counted };
            let several = Features { many_steps: true, ..lists };
            for one in [alone, counted, lists, several, Features { dda: true, ..all }] {
                sets.push(one);
                sets.push(waiting(one));
            }
        }
        sets.push(all);
        sets.push(waiting(all));
        sets.push(waiting(Features { live_lists: false, many_steps: false, ..all }));
        sets.push(waiting(Features { live_lists: true, many_steps: false, counters: true, ..base }));
    }
    sets
}

/// The same features, with walks, searches and sums over lights that wait for the next dispatch.
fn waiting(features: Features) -> Features {
    let resumes_scan = features.grid && features.counters && !features.many_steps;
    Features { resumes: true, resumes_scan, resumes_light: features.many_lights, turns: 100, ..features }
}

/// A kernel as it is compiled in a run with these features.
fn variant(kernel: Kernel, features: &Features) -> Result<Variant, ShaderError> {
    let kernels: Vec<Kernel> = kernel.program().kernels().filter(|&kernel| has_kernel(features, kernel)).collect();
    Variant::new(kernel, features, &live::lists_of(kernel, &live::lists(&kernels, features)))
}

/// Whether a run with these features has the kernel.
fn has_kernel(features: &Features, kernel: Kernel) -> bool {
    let f = features;
    match kernel.role() {
        Role::Step if f.many_steps => false,
        Role::Step if kernel == kernels::TRAVERSE_GRID => f.grid,
        Role::Step if kernel == kernels::TRAVERSE_IRREGULAR => f.irregular,
        Role::Step => f.bvh,
        Role::Whole => !f.live_lists,
        Role::Walk => f.live_lists && f.many_steps,
        Role::Test => !f.many_steps,
        Role::Sample => f.samples,
        _ => true,
    }
}

/// Writes a shader into the folder RAYSTEP_SHADERS, if there is one, for another compiler: see tests/web/shaders.test.mjs.
fn keep(name: &str, source: &str) {
    if let Some(folder) = std::env::var_os("RAYSTEP_SHADERS") {
        fs::write(Path::new(&folder).join(format!("{name}.wgsl")), source).expect("a folder");
    }
}

/// What WebGL 2 does not have of a shader without storage buffers, if anything.
fn lacking_in_webgl(source: &str) -> Option<String> {
    use naga::{AddressSpace, Expression, ScalarKind, TypeInner};
    let module = naga::front::wgsl::parse_str(source).expect("WGSL");
    let info = naga::valid::Validator::new(naga::valid::ValidationFlags::all(), naga::valid::Capabilities::all());
    let info = { info }.validate(&module).expect("a valid module");
    let mut layouter = naga::proc::Layouter::default();
    layouter.update(module.to_ctx()).expect("layouts");
    let uniforms = module.global_variables.iter().filter(|(_, global)| global.space == AddressSpace::Uniform);
    if let Some((_, uniform)) = { uniforms }.find(|(_, uniform)| !layouter[uniform.ty].size.is_multiple_of(16)) {
        return Some(format!("uniform {:?} of {} bytes", uniform.name, layouter[uniform.ty].size));
    }
    let plain = module.functions.iter().map(|(handle, function)| (function, &info[handle]));
    let entries = module.entry_points.iter().enumerate();
    let all = plain.chain(entries.map(|(index, entry)| (&entry.function, info.get_entry_point(index))));
    for (function, types) in all {
        let is_vector_of_no_floats = |expression: &Expression| {
            let Expression::Select { condition, accept, .. } = *expression else { return false };
            let of = |handle: naga::Handle<Expression>| types[handle].ty.inner_with(&module.types);
            let is_float = |ty: &TypeInner| ty.scalar_kind() == Some(ScalarKind::Float);
            matches!(of(condition), TypeInner::Vector { .. }) && !is_float(of(accept))
        };
        if function.expressions.iter().any(|(_, expression)| is_vector_of_no_floats(expression)) {
            return Some(format!("a select between vectors of integers in {:?}", function.name));
        }
    }
    None
}

/// Each choice of the fragment mapping, for the kernels that it can draw, with as many targets as core WebGPU has.
#[test]
fn every_fragment_program_is_valid_and_within_core_limits_and_those_of_webgl_without_buffers() {
    const CORE_TARGETS: usize = 2;
    let mut seen = HashSet::new();
    let mut check = |name: &str, shader: &fragment::Shader| {
        let count = |f: fn(&Resource) -> bool| shader.bindings.iter().filter(|b| f(&b.resource)).count();
        let textures = count(|r| matches!(r, Resource::ReadStream(_) | Resource::List));
        let buffers = count(|r| matches!(r, Resource::Storage | Resource::Live { .. }));
        assert!(textures <= 16 && buffers <= 8, "{name} binds {textures} textures, {buffers} buffers");
        if seen.insert(shader.source.clone()) {
            keep(&format!("draw-{:04}-{name}", seen.len()), &shader.source);
            // Those whose lists are in textures are for devices that only draw.
            if shader.bindings.iter().any(|b| b.resource == Resource::List) && name != "count" {
                assert_eq!(lacking_in_webgl(&shader.source), None, "{name}\n{}", shader.source);
            }
        }
    };
    let is_drawn = |role: Role| !matches!(role, Role::Whole | Role::Walk | Role::Sample | Role::Count);
    // Neither lists of rays, nor several steps, nor several samples.
    let one_step = |f: &Features| !(f.live_lists || f.many_steps || f.samples || f.eye_rays || f.resumes);
    for features in feature_sets().into_iter().filter(one_step) {
        let features = Features { fragments: true, ..features };
        let all = PROGRAM.kernels().filter(|&kernel| is_drawn(kernel.role()) && has_kernel(&features, kernel));
        for kernel in all {
            let variant = variant(kernel, &features).expect("a variant");
            // What ends a loop does not change a program.
            for how in Fragment::all().filter(|how| how.until == Until::Count) {
                let drawn =
                    DrawnKernel::new(&variant, how, CORE_TARGETS).unwrap_or_else(|e| panic!("{features:?}: {e}"));
                drawn.draws.iter().for_each(|draw| check(kernel.name(), &draw.shader));
                // Lists do not depend on what a fragment does with its colours.
                if how == Fragment::of(None, None, None, Some(Until::Count)) {
                    let drawn = drawn.in_textures().unwrap_or_else(|e| panic!("{features:?}: {e}"));
                    drawn.draws.iter().for_each(|draw| check(kernel.name(), &draw.shader));
                }
            }
        }
    }
    let all: Vec<Kernel> = PROGRAM.kernels().filter(|kernel| is_drawn(kernel.role())).collect();
    check("depths", &fragment::depths(streams::STATE, &all));
    let features = Features { fragments: true, ..Features::default() };
    check("count", &fragment::reader(&variant(kernels::COUNT, &features).expect("a variant")).expect("a reader"));
    assert!(seen.len() > 100, "{} programs", seen.len());
}

/// With RAYSTEP_SHADERS, also writes them into that folder.
#[test]
fn every_variant_is_valid_and_within_core_limits() {
    let (mut failures, mut seen) = (Vec::new(), HashSet::new());
    let mut check = |kernel: Kernel, features: &Features| match variant(kernel, features) {
        Err(e) => failures.push(format!("{features:?}: {e}")),
        Ok(variant) => {
            let count = |f: fn(&Resource) -> bool| variant.bindings.iter().filter(|b| f(&b.resource)).count();
            let textures = count(|r| matches!(r, Resource::WriteStream { .. }));
            let buffers = count(|r| matches!(r, Resource::Storage | Resource::Live { .. }));
            if textures > 4 || buffers > 8 {
                failures.push(format!("{} binds {textures} textures, {buffers} buffers", kernel.name()));
            }
            if seen.insert(variant.source.clone()) {
                keep(&format!("{:04}-{}", seen.len(), variant.label()), &variant.source);
                match variant.in_textures() {
                    Err(e) => failures.push(format!("{features:?}: {e}")),
                    Ok(textured) => {
                        let is_texture = |r: &Resource| matches!(r, Resource::ReadStream(_) | Resource::List);
                        let textures = textured.bindings.iter().filter(|b| is_texture(&b.resource)).count();
                        if textures > 16 {
                            failures.push(format!("{} binds {textures} textures for reading", kernel.name()));
                        }
                        keep(&format!("{:04}-{}-lists", seen.len(), variant.label()), &textured.source);
                    }
                }
            }
        }
    };
    for features in feature_sets() {
        PROGRAM.kernels().filter(|&kernel| has_kernel(&features, kernel)).for_each(|kernel| check(kernel, &features));
    }
    // Its kernels do not depend on the options of a walk.
    grid_build::PROGRAM.kernels().for_each(|kernel| check(kernel, &Features::default()));
    assert!(failures.is_empty(), "{}", failures.join("\n"));
    assert!(seen.len() > 100, "{} variants", seen.len());
}

/// Every run with light fits an adapter with no more than WebGPU guarantees, also where rays are in lists.
#[test]
fn light_needs_no_more_than_core_limits() {
    let core = Limits { storage_buffers: 8, storage_textures: 4, sampled_textures: 16, ..Limits::CPU };
    let mut several = generate::cornell_box();
    several.lights.extend(several.lights.clone());
    let mut runs = 0;
    for scene in [several, generate::whitted(1).expect("a scene"), generate::terrain(200, 1).expect("a scene")] {
        let camera = scene.cameras.first().cloned().expect("a camera");
        let rays = RaySource::Camera { camera, width: 8, height: 8 };
        for &integrator in Integrator::ALL {
            for &schedule in ScheduleKind::ALL {
                for accelerator in [Accelerator::Grid, Accelerator::Irregular, Accelerator::Bvh, Accelerator::None] {
                    for counters in [false, true] {
                        let base = Options::new(rays.clone());
                        let options = Options { integrator, schedule, accelerator, counters, ..base };
                        let label = format!("{} {integrator} {schedule} {accelerator}", scene.name);
                        let (plan, _) = Plan::new(&scene, &options, &core).unwrap_or_else(|e| panic!("{label}: {e}"));
                        for variant in &plan.variants {
                            // At an offset of their own in each pass; there may be four.
                            let moves =
                                |b: &&Binding| matches!(b.resource, Resource::Live { .. }) && b.name != live::LIVE_RAYS;
                            let moving = variant.bindings.iter().filter(moves).count();
                            assert!(moving <= 4, "{label}: {} binds {moving}", variant.kernel.name());
                        }
                        runs += 1;
                    }
                }
            }
        }
    }
    assert_eq!(runs, 3 * Integrator::ALL.len() * ScheduleKind::ALL.len() * 8);
}

#[test]
fn a_missing_option_is_an_error_and_not_silently_off() {
    let names: Vec<_> = Features::default().list().into_iter().map(|(name, _)| name).collect();
    let mut files = Vec::new();
    wgsl_files(&Path::new(env!("CARGO_MANIFEST_DIR")).join("src"), &mut files);
    for file in files {
        let text = fs::read_to_string(&file).expect("text");
        for option in text.match_indices("@if(").map(|(at, _)| &text[at + 4..]) {
            let condition = &option[..option.find(')').expect("closed")];
            for word in condition.split(|c: char| !(c.is_alphanumeric() || c == '_')).filter(|w| !w.is_empty()) {
                assert!(names.contains(&word), "{}: @if({condition})", file.display());
            }
        }
    }
}

/// The WGSL files in a folder and below it.
fn wgsl_files(folder: &Path, found: &mut Vec<PathBuf>) {
    for entry in fs::read_dir(folder).expect("a folder").map(|entry| entry.expect("an entry").path()) {
        if entry.is_dir() {
            wgsl_files(&entry, found);
        } else if entry.extension().is_some_and(|e| e == "wgsl") {
            found.push(entry);
        }
    }
}

/// A file with many conditions is several files in one. What differs between structures, or between rules, is in a file
/// for each of them.
#[test]
fn no_file_has_more_conditions_than_a_reader_can_follow() {
    const MOST: usize = 15;
    let mut files = Vec::new();
    let sources = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    wgsl_files(&sources, &mut files);
    assert!(files.len() > 60, "{} files", files.len());
    for file in files {
        let text = fs::read_to_string(&file).expect("text");
        let conditions: usize = ["@if", "@else", "@elif"].iter().map(|word| text.matches(word).count()).sum();
        assert!(conditions <= MOST, "{} has {conditions} conditions, more than {MOST}", file.display());
    }
}

/// The paper's Table 1, with deviations explained.
#[test]
fn kernels_write_what_table_1_says() {
    use streams::{COLOR, HIT, RAY_DIRECTION, RAY_ORIGIN, STATE, TMAX};
    let table = [
        // hit is set to "no triangle" with the ray; the paper discards fragments instead.
        (kernels::GENERATE, &[RAY_ORIGIN, RAY_DIRECTION, STATE, HIT][..]),
        // The paper's set-up copies the ray to a second pair of textures; in place there is nothing to copy.
        (kernels::SETUP, &[STATE, TMAX]),
        (kernels::TRAVERSE_GRID, &[STATE, TMAX]),
        (kernels::INTERSECT, &[STATE, HIT]),
        // The state becomes DONE, so that the live counts tell when the image is complete.
        (kernels::SHADE, &[STATE, COLOR]),
    ];
    let features = Features { robust: true, grid: true, clip: true, perspective: true, ..Features::default() };
    for (kernel, expected) in table {
        let variant = variant(kernel, &features).expect("valid");
        let mut written: Vec<_> = variant.streams().filter(|(_, b)| b.writes).map(|(s, _)| s).collect();
        let mut expected = expected.to_vec();
        written.sort();
        expected.sort();
        assert_eq!(written, expected, "{}", kernel.name());
    }
}

#[test]
fn host_structs_lie_as_naga_says() {
    let mut all = Features { robust: true, grid: true, textures: true, spot_lights: true, ..Features::default() };
    (all.many_lights, all.samples) = (true, true);
    let mut layouts = Vec::new();
    for features in [all, Features { grid: false, ..all }, Features { grid: false, bvh: true, ..all }] {
        for kernel in PROGRAM.kernels().filter(|&k| has_kernel(&features, k)) {
            layouts.extend(variant(kernel, &features).expect("valid").structs);
        }
    }
    macro_rules! check {
        ($host:ty, $name:literal, $($field:ident),*) => {
            let layout = layouts.iter().find(|l| l.name == $name).expect($name);
            assert_eq!(layout.size as usize, size_of::<$host>(), $name);
            let host = [$((stringify!($field), offset_of!($host, $field))),*];
            assert_eq!(layout.members.len(), host.len(), $name);
            for (member, offset) in &layout.members {
                let found = host.iter().find(|(n, _)| n == member);
                assert_eq!(found.map(|f| f.1), Some(*offset as usize), "{}.{member}", $name);
            }
        };
    }
    check!(Camera, "Camera", eye, pixel_x, right, pixel_y, up, forward);
    check!(Grid, "Grid", corner, cells, levels, width, inverse_width);
    check!(Sampling, "Sampling", samples, seed, first);
    check!(Shading, "Shading", background, lights);
    check!(Material, "Material", base_color, texture, emissive, double_sided);
    check!(Light, "Light", position, kind, direction, cos_outer, color, cone_scale);
    check!(Texture, "Texture", first, width, height, sampling);
    check!(SceneInfo, "SceneInfo", triangles, steps, rays, first_row, size, padding);
    check!(BvhNode, "BvhNode", min, first, max, link);
}
