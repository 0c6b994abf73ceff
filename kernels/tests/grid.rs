//! The grid lists everything that a ray can hit, and little more.

use raystep_kernels::structures::grid::{self, GridError, GridSize, automatic_cells, build};

/// Corners of pseudo-random triangles of a given size in the box [-1, 1] times `extent`.
fn soup(count: usize, size: f32, extent: [f32; 3]) -> Vec<f32> {
    let mut random = fastrand::Rng::with_seed(1);
    let mut unit = || random.f32() * 2.0 - 1.0;
    let mut vertices = Vec::new();
    for _ in 0..count {
        let center = extent.map(|e| unit() * e);
        for _ in 0..3 {
            vertices.extend((0..3).map(|a| center[a] + if extent[a] == 0.0 { 0.0 } else { unit() * size }));
        }
    }
    vertices
}

#[test]
fn every_point_of_every_triangle_lies_in_a_cell_that_lists_it() {
    for (extent, size) in
        [([1.0; 3], 0.1), ([1.0; 3], 0.9), ([1.0, 0.0, 1.0], 0.2), ([1.0, 0.0, 0.0], 0.2), ([0.0; 3], 0.0)]
    {
        let vertices = soup(300, size, extent);
        for cells in [GridSize::Auto, GridSize::Cells([1, 1, 1]), GridSize::Cells([13, 7, 29])] {
            let built = build(&vertices, cells, 4.0, u64::MAX).expect("a grid");
            for (triangle, v) in vertices.chunks_exact(9).enumerate() {
                for i in 0..=8 {
                    for j in 0..=8 - i {
                        let (b, c) = (f64::from(i) / 8.0, f64::from(j) / 8.0);
                        let point = [0, 1, 2].map(|a| {
                            f64::from(v[a]) * (1.0 - b - c) + f64::from(v[a + 3]) * b + f64::from(v[a + 6]) * c
                        });
                        let cell = [0, 1, 2].map(|a| {
                            let at = (point[a] - f64::from(built.grid.corner[a])) / f64::from(built.grid.width[a]);
                            at.floor() as i32
                        });
                        assert!(built.grid.is_in_grid(cell), "{extent:?} {cells:?}: {point:?} is outside");
                        let list = built.list(built.grid.cell_index(cell));
                        assert!(list.contains(&(triangle as u32)), "{extent:?} {cells:?}: {triangle} at {point:?}");
                    }
                }
            }
        }
    }
}

#[test]
fn lists_are_ascending_and_cells_that_a_triangle_does_not_touch_do_not_list_it() {
    let vertices = soup(500, 0.3, [1.0; 3]);
    let built = build(&vertices, GridSize::Cells([20; 3]), 4.0, u64::MAX).expect("a grid");
    for cell in 0..built.cells.len() as u32 - 1 {
        assert!(built.list(cell).windows(2).all(|w| w[0] < w[1]));
    }
    let references = built.items.len();
    // By the triangles' boxes alone, cells would list about three times as many.
    let boxes: usize = vertices
        .chunks_exact(9)
        .map(|v| {
            (0..3)
                .map(|a| {
                    let cell = |x: f32| ((x - built.grid.corner[a]) / built.grid.width[a]) as i32;
                    let (low, high) = (v[a].min(v[a + 3]).min(v[a + 6]), v[a].max(v[a + 3]).max(v[a + 6]));
                    (cell(high) - cell(low) + 1) as usize
                })
                .product::<usize>()
        })
        .sum();
    assert!(references * 2 < boxes, "{references} references, {boxes} by boxes");
}

#[test]
fn growing_the_cells_adds_less_than_a_hundredth() {
    let vertices = soup(20_000, 0.02, [1.0; 3]);
    let built = build(&vertices, GridSize::Auto, 4.0, u64::MAX).expect("a grid");
    let stats = built.stats(&vertices);
    assert!(stats.added_by_growth * 100 < stats.references, "{stats:?}");
    assert!(stats.added_by_growth > 0, "20,000 triangles must touch some grown face: {stats:?}");
}

#[test]
fn planes_are_exact() {
    for offset in [0.0f32, 1.0, -0.3, 1000.0] {
        let mut vertices: Vec<f32> = soup(50, 0.1, [0.8; 3]).iter().map(|v| v + offset).collect();
        // Bounds just below a power of two leave the least headroom.
        vertices.extend([0.99998, -0.99998, 0.99998].iter().cycle().take(9));
        vertices.extend([-0.99998, 0.99998, -0.99998].iter().cycle().take(9));
        for n in [1, 3, 20, 1001, 4011] {
            let g = build(&vertices, GridSize::Cells([n, 1, 2]), 4.0 + offset.abs(), u64::MAX).expect("a grid").grid;
            for i in 0..=n {
                let exact = f64::from(g.corner[0]) + f64::from(g.width[0]) * f64::from(i);
                let plane = g.cell_plane::<f32>([i as i32, 0, 0]).x;
                assert_eq!(f64::from(plane), exact, "offset {offset}, plane {i} of {n}");
                // Also if contracted: the product alone is exact too.
                assert_eq!(f64::from(g.width[0] * i as f32), f64::from(g.width[0]) * f64::from(i));
            }
        }
    }
}

#[test]
fn automatic_cells_suit_flat_and_single_shapes() {
    assert_eq!(automatic_cells(0, [0.0; 3]), [1; 3]);
    assert_eq!(automatic_cells(1000, [1.0, 0.0, 0.0])[1..], [1, 1]);
    let flat = automatic_cells(10_000, [1.0, 0.0, 1.0]);
    assert_eq!((flat[0], flat[1]), (flat[2], 1));
    let cube = automatic_cells(10_000, [1.0; 3]);
    let product = f64::from(cube[0]) * f64::from(cube[1]) * f64::from(cube[2]);
    assert!((product / (10_000.0 * grid::CELLS_PER_TRIANGLE) - 1.0).abs() < 0.1, "{cube:?}");
}

#[test]
fn grids_for_leaps_are_finer_and_fit_what_there_is() {
    let vertices = soup(10_000, 0.01, [1.0; 3]);
    let cells = |most: u64| {
        let built = grid::build_for_leaps(&vertices, 4.0, most).expect("a grid");
        assert!(built.cells.len() as u64 <= most && built.items.len() as u64 <= most);
        built.grid.cells.iter().map(|&n| f64::from(n)).product::<f64>()
    };
    let wanted = 10_000.0 * grid::LEAPING_CELLS_PER_TRIANGLE;
    assert!((cells(u64::MAX) / wanted - 1.0).abs() < 0.1);
    assert!(cells(100_000) < 100_000.0);
}

#[test]
fn sizes_that_cannot_be_are_refused() {
    for cells in [[0, 1, 1], [5000, 1, 1], [4096, 4096, 4096]] {
        assert_eq!(build(&[0.0; 9], GridSize::Cells(cells), 1.0, u64::MAX), Err(GridError::Size(cells)));
    }
}

#[test]
fn ten_thousand_triangles_that_fill_the_scene_get_a_grid_that_fits_memory() {
    let vertices = soup(10_000, 1.0, [1.0; 3]);
    let built = build(&vertices, GridSize::Auto, 4.0, u64::MAX).expect("a grid");
    assert!(built.items.len() <= 16 * 10_000 + 4096, "{}", built.items.len());
}

/// With triangles that overlap every cell, counting would take triangles times cells steps.
#[test]
fn a_hundred_thousand_triangles_that_fill_the_scene_are_given_up_on_early() {
    let vertices = soup(100_000, 1.0, [1.0; 3]);
    let built = build(&vertices, GridSize::Auto, 4.0, u64::MAX).expect("a grid");
    assert!(built.items.len() <= 16 * 100_000 + 4096, "{}", built.items.len());
    let (cells, limit) = ([100; 3], 10_000_000);
    let huge = build(&vertices, GridSize::Cells(cells), 4.0, limit);
    assert_eq!(huge, Err(GridError::TooManyReferences { cells, limit }));
}

/// If f32 cannot distinguish the two ends of the scene, there is one cell that lists everything.
#[test]
fn origins_so_far_away_that_cells_mean_nothing_get_one_cell() {
    let vertices = soup(1000, 0.1, [1.0; 3]);
    let built = build(&vertices, GridSize::Auto, 1e9, u64::MAX).expect("a grid");
    assert_eq!((built.grid.cells, built.items.len()), ([1; 3], 1000));
}
