//! Compares the chained CPU reference functions with the host's build; composes and validates the kernels' WGSL.

use naga::valid::{Capabilities, ValidationFlags, Validator};
use raystep_scenes::generate;

use super::bound::bound;
use super::device::tests::composed;
use super::emit::emit;
use super::kernels::ROWS;
use super::mark::mark;
use super::measure::measure;
use super::span::span;
use crate::program::KernelInfo;
use crate::programs::primitives::histogram::histogram;
use crate::programs::primitives::radix::{DIGIT_BITS, DIGITS, digits_of};
use crate::programs::primitives::scan::{EACH, SCAN_BLOCK};
use crate::programs::primitives::scatter::{places, scatter};
use crate::programs::primitives::tests::prefix;
use crate::shared::build::Build;
use crate::shared::launch::{BLOCK, Launch};
use crate::structures::grid::{self, GridData, GridSize};

/// Scenes whose lists are easy or hard to decide.
pub(super) fn scenes() -> Vec<(&'static str, Vec<f32>)> {
    let of = |scene: raystep_scenes::Scene| scene.triangles.as_flattened().as_flattened().to_vec();
    let soup = of(generate::soup(700, 1).expect("soup"));
    let mut random = fastrand::Rng::with_seed(3);
    // Corners on planes and on each other, and triangles that are points or lines.
    let whole: Vec<f32> = (0..900).map(|_| random.i32(-4..5) as f32 * 0.25).collect();
    let points = whole.chunks_exact(9).flat_map(|v| [&v[..3], &v[..3], &v[3..6]].concat()).collect();
    // If all three corners are NaN, so is the box, and the first cell lists the triangle.
    let mut no_corners = soup.clone();
    no_corners[9..18].fill(f32::NAN);
    no_corners[30] = f32::NAN;
    vec![
        ("cornell box", of(generate::cornell_box())),
        ("terrain", of(generate::terrain(800, 2).expect("terrain"))),
        ("small soup", soup[..180].iter().map(|v| v * 1e-36).collect()),
        ("large soup", soup.iter().map(|v| v * 1e30 + 1e30).collect()),
        ("soup", soup),
        ("one large triangle", vec![-1.0, -0.9, -0.8, 1.0, -0.7, 0.9, -0.2, 1.0, 0.3]),
        ("a thin long one", vec![-10.0, 0.0, 0.0, 10.0, 0.3, 0.01, 10.0, 0.3001, 0.01]),
        ("a flat one", vec![0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0]),
        ("corners on planes", whole),
        ("corners that are none", no_corners),
        ("points and lines", points),
        ("a bundle", bundle()),
        ("corners on those of cells", touching()),
        ("nothing", vec![]),
    ]
}

/// Long triangles side by side: lists that are too long for one thread, and of which neighbours share most.
fn bundle() -> Vec<f32> {
    let mut random = fastrand::Rng::with_seed(7);
    let triangle = |_| {
        let end = random.f32() * 4.0 - 2.0;
        [-2.0, 0.01 * random.f32(), 0.01 * random.f32(), end, 0.02, 0.01, end, 0.03 * random.f32(), 0.0]
    };
    (0..80).flat_map(triangle).collect()
}

/// Triangles with a corner exactly at the corner of a grown cell, for [`TOUCHED`]: whether they overlap depends on the
/// last bit of every sum.
fn touching() -> Vec<f32> {
    let mut random = fastrand::Rng::with_seed(5);
    let mut vertices = [[-2.0; 9], [2.0; 9]].concat();
    let built = grid::build(&vertices, GridSize::Cells(TOUCHED), reach(&vertices), u64::MAX).expect("a grid");
    for _ in 0..2000 {
        vertices.extend([0, 1, 2].map(|a| {
            let plane = built.grid.corner[a] + built.grid.width[a] * random.i32(1..TOUCHED[a] as i32) as f32;
            if random.bool() { plane + built.growth } else { plane - built.growth }
        }));
        // Of many sizes, so that products have more bits than are kept.
        vertices.extend((0..6).map(|_| (random.f32() * 4.0 - 2.0) * 0.5f32.powi(random.i32(0..16))));
    }
    vertices
}

const TOUCHED: [u32; 3] = [16; 3];

fn reach(vertices: &[f32]) -> f32 {
    4.0 * vertices.iter().fold(0.0f32, |most, v| most.max(v.abs()))
}

/// Each scene at several resolutions, with the grid that the host builds.
pub(super) fn cases() -> Vec<(String, Vec<f32>, GridData)> {
    let mut cases = Vec::new();
    for (name, vertices) in scenes() {
        let reach = reach(&vertices);
        for size in [[1; 3], [13, 7, 29], TOUCHED, [64; 3], [300, 1, 3], [2, 40, 1]] {
            let built = grid::build(&vertices, GridSize::Cells(size), reach, u64::MAX).expect("a grid");
            cases.push((format!("{name} {size:?}"), vertices.clone(), built));
        }
        let built = grid::build(&vertices, GridSize::Auto, reach, u64::MAX).expect("a grid");
        cases.push((format!("{name}, automatic"), vertices.clone(), built));
        let built = grid::build_for_leaps(&vertices, reach, u64::MAX).expect("a grid");
        cases.push((format!("{name}, for leaps"), vertices.clone(), built));
        let counted = grid::count_lists(&vertices, GridSize::Cells([16; 3]), reach, false, u64::MAX);
        cases.push((format!("{name}, not grown"), vertices.clone(), counted.expect("a grid").fill(&vertices)));
    }
    // Cells smaller than their growth list nearly everything.
    cases.retain(|(_, _, built)| built.items.len() < 500_000);
    assert!(cases.len() > 80, "{} cases", cases.len());
    cases
}

/// The build as done by the kernels; returns starts and lists.
fn lists(vertices: &[f32], wanted: &GridData) -> (Vec<u32>, Vec<u32>) {
    let (grid, growth) = (&wanted.grid, wanted.growth);
    let build = Build::new(grid, growth, (vertices.len() / 9) as u32);
    let (boxes, mut first_span): (Vec<_>, Vec<_>) = vertices.chunks_exact(9).map(|t| bound(t, grid, growth)).unzip();
    let spans = prefix(&mut first_span);
    let spans: Vec<_> = (0..spans).map(|i| span(i, &first_span, &boxes, grid, growth, vertices)).collect();
    let mut first_reference: Vec<u32> = spans.iter().map(|span| span.mask.count_ones()).collect();
    let references = prefix(&mut first_reference) as usize;
    let mut from = (vec![0; references], vec![0; references]);
    let mut to = from.clone();
    for (span, &first) in spans.iter().zip(&first_reference) {
        emit(span, first, build.cells, &mut from.0, &mut from.1);
    }
    let cells = build.cells.iter().product();
    for digit in 0..digits_of(cells) {
        let mut tally = vec![0; DIGITS * references.div_ceil(BLOCK)];
        histogram(digit, &from.0, &mut tally);
        prefix(&mut tally);
        let places = places(digit, &from.0, &tally);
        scatter(&places, &from.0, &mut to.0);
        scatter(&places, &from.1, &mut to.1);
        std::mem::swap(&mut from, &mut to);
    }
    let mut begin = vec![0; cells as usize];
    let (mut end, mut start) = (begin.clone(), begin.clone());
    mark(&from.0, &mut begin, &mut end);
    measure(&begin, &end, &mut start);
    let total = prefix(&mut start);
    start.push(total);
    (start, from.1)
}

#[test]
fn the_reference_functions_build_the_grids_that_the_host_builds() {
    let mut references = 0;
    for (name, vertices, wanted) in cases() {
        let (starts, items) = lists(&vertices, &wanted);
        assert!(starts == wanted.cells, "{name}: other starts");
        assert!(items == wanted.items, "{name}: other lists");
        references += items.len();
    }
    assert!(references > 100_000, "{references} references are too few to show anything");
}

#[test]
fn every_kernel_is_valid_and_agrees_with_the_host_about_sizes() {
    let mut faults = String::new();
    let mut structs = 0;
    for &KernelInfo { name, wgsl, .. } in ROWS {
        let source = composed(name, wgsl);
        let module = match naga::front::wgsl::parse_str(&source) {
            Ok(module) => module,
            Err(error) => {
                faults += &error.emit_to_string(&source);
                continue;
            }
        };
        if let Err(error) = Validator::new(ValidationFlags::all(), Capabilities::empty()).validate(&module) {
            faults += &error.emit_to_string(&source);
        }
        let entry = module.entry_points.iter().find(|entry| entry.name == name).expect("its entry point");
        assert_eq!(entry.workgroup_size, [BLOCK as u32, 1, 1], "{name}");
        let storage = module.global_variables.iter().filter(|(_, global)| {
            use naga::{ImageClass, TypeInner};
            matches!(module.types[global.ty].inner, TypeInner::Image { class: ImageClass::Storage { .. }, .. })
        });
        assert!(storage.count() <= 4, "{name}: core WebGPU has 4 storage textures a stage");
        for (_, ty) in module.types.iter() {
            let (Some(name), naga::TypeInner::Struct { span, .. }) = (&ty.name, &ty.inner) else { continue };
            match name.as_str() {
                "Launch" => assert_eq!(*span as usize, size_of::<Launch>()),
                "Build" => assert_eq!(*span as usize, size_of::<Build>()),
                _ => continue,
            }
            structs += 1;
        }
        // Only a filter, which leaves to integers what it cannot decide for certain, uses floats.
        let is_float = |ty: &naga::Type| ty.inner.scalar_kind() == Some(naga::ScalarKind::Float);
        let is_filtered = ["bound", "span", "halve"].contains(&name);
        assert_eq!(module.types.iter().any(|(_, ty)| is_float(ty)), is_filtered, "{name}: floats");
    }
    assert!(faults.is_empty(), "{faults}");
    assert!(structs > ROWS.len(), "Launch in all, Build in some");
    let radix = composed("histogram", super::kernels::HISTOGRAM.wgsl);
    assert!(radix.contains(&format!("const DIGIT_BITS: u32 = {DIGIT_BITS}u;")), "{radix}");
    assert!(radix.contains(&format!("const DIGITS: u32 = {DIGITS}u;")), "{radix}");
}

/// Numbers that decide what is built are the same in both languages.
#[test]
fn constants_of_the_wgsl_are_those_of_the_host() {
    use crate::shared::constants::{LAST_ITEM, NO_LIST};
    use crate::structures::irregular::{expand, merge, refine};
    let all = [
        ("make_leaves", "CELLS_PER_REFERENCE", refine::CELLS_PER_REFERENCE),
        ("make_leaves", "GROWTH", refine::GROWTH),
        ("make_leaves", "GROWTH_OF_ALL", refine::GROWTH_OF_ALL),
        ("make_leaves", "CROWDED", refine::CROWDED),
        ("halve", "SHORT", refine::SHORT as u64),
        ("decide", "LONG", refine::LONG as u64),
        ("decide", "STEP_COST", refine::STEP_COST as u64),
        ("wish", "LONGEST", merge::LONGEST as u64),
        ("wish", "STEP_COST", merge::STEP_COST),
        ("next_axis", "ROUNDS", merge::ROUNDS.into()),
        ("next_axis", "LEAST_MERGED", merge::LEAST_MERGED as u64),
        ("expand", "ROUNDS", expand::ROUNDS.into()),
        ("expand", "MOST_LOOKED_AT", expand::MOST_LOOKED_AT.into()),
        ("finish_cells", "NO_LIST", NO_LIST.into()),
        ("finish_items", "LAST_ITEM", LAST_ITEM.into()),
        ("check_cells", "NO_LIST", NO_LIST.into()),
        ("check_cells", "LAST_ITEM", LAST_ITEM.into()),
        ("scan", "EACH", EACH.into()),
        ("check_items", "EACH", EACH.into()),
        ("gather", "SUMMED", SCAN_BLOCK as u64),
        ("add", "SCAN_BLOCK", SCAN_BLOCK as u64),
        ("halve", "EACH", super::irregular::kernels::HALVE_EACH.into()),
    ];
    for (kernel, name, value) in all {
        let row = ROWS.iter().find(|row| row.name == kernel).expect("a kernel");
        let source = composed(kernel, row.wgsl);
        let line = source.lines().find(|line| line.starts_with(&format!("const {name}: u32 = "))).expect(name);
        let number = line.split(" = ").nth(1).expect("a value").trim_end_matches("u;");
        let number = match number.strip_prefix("0x") {
            Some(hex) => u64::from_str_radix(hex, 16),
            None => number.parse(),
        };
        assert_eq!(number, Ok(value), "{kernel}: {line}");
    }
}
