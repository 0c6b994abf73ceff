use super::*;
use crate::numbers::real::Vec3;
use crate::shared::grid_walk::WalkRules;
use crate::structures::grid::overlap::Overlap;
use raystep_scenes::{Scene, generate};

const RULES: WalkRules = WalkRules { robust: true, clip: true, drifting: false, dda: false };

fn vertices_of(scene: &Scene) -> Vec<f32> {
    let units = crate::numbers::units::Units::of(scene);
    crate::scene_data::traced_vertices(scene, units)
}

fn scenes() -> Vec<(&'static str, Vec<f32>)> {
    vec![
        ("cornell", vertices_of(&generate::cornell_box())),
        ("soup", vertices_of(&generate::soup(3000, 1).expect("a scene"))),
        ("terrain", vertices_of(&generate::terrain(5000, 1).expect("a scene"))),
        ("room", vertices_of(&generate::tiny_in_room(3000, 100).expect("a scene"))),
        ("hair", vertices_of(&generate::hair(300, 1).expect("a scene"))),
        (
            "pile",
            (0..2_000)
                .flat_map(|i| {
                    let z = i as f32 / 2_000.0;
                    [-1.0, -1.0, z, 1.0, -1.0, z, 1.0, 1.0, z]
                })
                .collect(),
        ),
        ("nothing", Vec::new()),
        (
            "flat",
            (0..500)
                .flat_map(|i| {
                    let (x, y) = ((i % 23) as f32 / 23.0, (i / 23) as f32 / 23.0);
                    [x, y, 0.0, x + 0.06, y, 0.0, x, y + 0.05, 0.0]
                })
                .collect(),
        ),
    ]
}

/// Deterministic numbers.
struct Random(u32);

impl Random {
    fn next(&mut self) -> u32 {
        self.0 = self.0.wrapping_mul(747_796_405).wrapping_add(2_891_336_453);
        let word = ((self.0 >> (self.0 >> 28).wrapping_add(4)) ^ self.0).wrapping_mul(277_803_737);
        word >> 22 ^ word
    }

    fn unit(&mut self) -> f32 {
        (self.next() >> 8) as f32 / (1 << 24) as f32
    }

    fn voxel(&mut self, low: [i32; 3], high: [i32; 3]) -> [i32; 3] {
        [0, 1, 2].map(|a| low[a] + (self.next() % (high[a] - low[a]) as u32) as i32)
    }
}

/// Irregular grids over all scenes, and grids of two levels.
fn built_in_both_ways() -> impl Iterator<Item = (&'static str, Vec<f32>, IrregularData)> {
    scenes().into_iter().flat_map(|(name, vertices)| {
        let irregular = build(&vertices, Some([[-2.0; 3], [2.0; 3]]), true, u64::MAX).expect("a grid");
        assert_eq!(irregular.aside > 0, name == "room", "{name}");
        let two_levels = build_two_levels(&vertices, [9, 10, 11], 4.0, true, u64::MAX).expect("a grid");
        assert_eq!(two_levels.grid.cells.map(|n| n >> two_levels.grid.levels), [9, 10, 11]);
        [irregular, two_levels].map(|built| (name, vertices.clone(), built))
    })
}

/// Cells of one size where lists are short, and smaller ones of one size in each of the others.
#[test]
fn only_crowded_cells_have_a_second_level() {
    let mut divided = 0;
    for (name, vertices) in scenes() {
        let built = build_two_levels(&vertices, [4, 5, 6], 4.0, true, u64::MAX).expect("a grid");
        let plan = Layout::below(&vertices, 4.0, true, [4, 5, 6]);
        let top = grid::lists(&plan.at(0), plan.growth, &vertices, u64::MAX).expect("lists");
        for cell in 0..4 * 5 * 6 {
            let is_divided = built.map[cell] & 3 != 0;
            let list = top.list(cell as u32);
            assert!(list.len() > 16 || !is_divided, "{name}: {} triangles", list.len());
            if !is_divided {
                assert!(built.list(built.map[cell] >> 2).eq(list.iter().copied()), "{name}");
            }
            divided += u32::from(is_divided);
        }
        println!("{name}: {} cells, longest list {:?}", built.cells.len(), built.lengths.iter().max());
    }
    assert!(divided > 100, "{divided} cells");
}

/// In random virtual cells, and in random ones of expanded boxes: every triangle that meets one, grown, is listed.
#[test]
fn lists_hold_what_meets_any_part_of_their_cells() {
    for (name, vertices, built) in built_in_both_ways() {
        let mut random = Random(7);
        let first = usize::from(built.aside > 0) as u32;
        let aside: Vec<u32> = built.list(OUTSIDE).take(built.aside as usize).collect();
        let triangles = vertices.len() as u32 / 9;
        let walls = if name == "room" && built.aside > 0 { triangles - 12..triangles } else { 0..0 };
        assert_eq!(aside, walls.collect::<Vec<_>>(), "{name}: set aside");
        let check = |voxel: [i32; 3], cell: u32| {
            let list: Vec<u32> = built.list(cell).collect();
            assert!(list.is_sorted());
            assert!(list.iter().all(|triangle| !aside.contains(triangle)));
            for (triangle, corners) in vertices.chunks_exact(9).enumerate() {
                if aside.contains(&(triangle as u32)) {
                    continue;
                }
                let overlap = Overlap::new(&built.grid, f64::from(built.growth), corners);
                let is_near = (0..3).all(|a| overlap.low[a] <= voxel[a] && voxel[a] <= overlap.high[a]);
                if is_near && overlap.span_mask(voxel, 1) == 1 {
                    assert!(list.contains(&(triangle as u32)), "{name}: {voxel:?} in cell {cell} meets {triangle}");
                }
            }
        };
        for _ in 0..300 {
            let voxel = random.voxel([0; 3], built.grid.cells);
            let cell = built.find(voxel);
            let [low, high] = built.cells[cell as usize].corners();
            assert!((0..3).all(|a| low[a] <= voxel[a] && voxel[a] < high[a]), "{name}: {voxel:?} in {low:?} {high:?}");
            check(voxel, cell);
            check(random.voxel(low, high), cell);
            let full = first + random.next() % (built.cells.len() as u32 - first);
            let [low, high] = built.cells[full as usize].corners();
            check(random.voxel(low, high), full);
        }
    }
}

/// Cells visited and triangles listed there, by random lines through the whole scene: fewer than in a uniform grid.
#[test]
fn rays_take_few_steps() {
    for (name, vertices) in scenes() {
        let built = build(&vertices, Some([[-2.0; 3], [2.0; 3]]), true, u64::MAX).expect("a grid");
        let uniform =
            crate::structures::grid::build(&vertices, crate::options::GridSize::Auto, 4.0, u64::MAX).expect("a grid");
        let mut random = Random(9);
        let (mut steps, mut tests, mut cells, mut listed) = (0u64, 0u64, 0u64, 0u64);
        for _ in 0..500 {
            let point =
                |random: &mut Random| {
                    Vec3::from([0, 1, 2].map(|a| {
                        built.grid.corner[a] + random.unit() * built.grid.width[a] * built.grid.cells[a] as f32
                    }))
                };
            let (origin, target) = (point(&mut random), point(&mut random));
            let direction = target - origin;
            let ray = built.grid.ray(RULES, origin, direction);
            let mut walk = Some(built.grid.enter(RULES, &ray)).filter(|walk| walk.inside).map(|walk| walk.cell);
            while let Some(voxel) = walk {
                let index = built.find(voxel);
                let cell = built.cells[index as usize];
                steps += 1;
                tests += built.list(index).count() as u64;
                walk = cell.next(&built.grid, voxel, cell.exit(&built.grid, &ray), &ray);
            }
            let ray = uniform.grid.ray(RULES, origin, direction);
            let mut walk = uniform.grid.enter(RULES, &ray);
            while walk.inside {
                cells += 1;
                listed += uniform.list(uniform.grid.cell_index(walk.cell)).len() as u64;
                walk = uniform.grid.advance(RULES, walk, &ray);
            }
        }
        println!(
            "{name}: {} cells, {} items, map {}, virtual {:?} levels {}; irregular {:.1} steps {:.1} tests, uniform {:.1} {:.1}",
            built.cells.len(),
            built.items.len(),
            built.map.len(),
            built.grid.cells,
            built.grid.levels,
            steps as f64 / 500.0,
            tests as f64 / 500.0,
            cells as f64 / 500.0,
            listed as f64 / 500.0
        );
        assert!(name == "nothing" || steps + tests < cells + listed, "{name}");
    }
}

#[test]
fn a_grid_that_fits_no_buffer_is_refused_in_its_own_words() {
    let vertices = vertices_of(&generate::soup(3000, 1).expect("a scene"));
    let error = build(&vertices, Some([[-2.0; 3], [2.0; 3]]), true, 100).expect_err("too small a buffer");
    assert_eq!(error, GridError::TooManyCells { triangles: 3000, limit: 100 });
}
