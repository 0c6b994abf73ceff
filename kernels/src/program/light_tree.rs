//! A pixel's light tree: where its light comes from, ray by ray.
//!
//! Every ray of the pixel ends in a vertex below the one that it left (the tree of rays of Whitted, 1980). What vertices
//! contribute adds up to the pixel's colour. A program whose rays form such a tree has a function that [grows](Grow) it
//! from the ray before and after each pass; histories, tables and drawings read the tree alone.

use super::RayState;
use super::paths::Density;
use crate::numbers::named::named;
use crate::scene_data::SceneData;

/// What a vertex is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize), serde(rename_all = "snake_case"))]
pub enum VertexKind {
    /// Where the rays of a sample begin.
    Camera,
    /// A surface that a ray hit.
    Surface,
    /// A light, sampled from a surface.
    Light,
    /// What a ray sees that hits nothing.
    Background,
}

named!(VertexKind, Camera "camera", Surface "surface", Light "light", Background "background");

/// Where a vertex is.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub enum Place {
    /// A point, in scene units.
    #[cfg_attr(feature = "serde", serde(rename = "point_scene"))]
    Point([f64; 3]),
    /// Infinitely far away in this direction.
    #[cfg_attr(feature = "serde", serde(rename = "direction"))]
    Direction([f64; 3]),
}

/// What became of the ray to a vertex.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize), serde(rename_all = "snake_case"))]
pub enum Fate {
    /// It is on its way.
    Open,
    /// It reaches the vertex.
    Reached,
    /// A triangle is in its way.
    Occluded {
        /// The triangle.
        triangle: u32,
        /// Where it is met, in scene units.
        point_scene: [f64; 3],
    },
    /// None was cast.
    NotCast,
}

/// A pass of a pixel's history.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct Step {
    /// Its row of the history.
    pub row: usize,
    /// Its index in the run, if that is known.
    pub pass: Option<usize>,
}

/// A vertex.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct Vertex {
    /// What it is.
    pub kind: VertexKind,
    /// The vertex that the ray to it left; `None` for a camera.
    pub parent: Option<usize>,
    /// The sample of the pixel, from 0.
    pub sample: u32,
    /// What the ray to it is: `camera`, `shadow`, or what a surface did, such as `reflected`.
    pub ray: &'static str,
    /// Surfaces between the camera and the surface that the ray to it left or, for a surface, that it is.
    pub depth: u32,
    /// Where it is.
    #[cfg_attr(feature = "serde", serde(flatten))]
    pub place: Place,
    /// The triangle of a surface.
    pub triangle: Option<u32>,
    /// The number of a light, from 1.
    pub light: Option<u32>,
    /// What became of the ray to it.
    pub fate: Fate,
    /// Linear light that the ray brings to where it began, or would bring if it reached the vertex: emitted by a surface,
    /// <N, L> times the colour of a light. `None` for a camera, and for a surface that emits nothing.
    pub arrives: Option<[f32; 3]>,
    /// The share of light along the ray to it that reaches the pixel; of a light, along the ray to the surface it was sampled
    /// from. `None` if that is not followed.
    #[cfg_attr(feature = "serde", serde(skip_serializing_if = "Option::is_none"))]
    pub throughput: Option<[f32; 3]>,
    /// The densities of its light's sample, if it was sampled.
    #[cfg_attr(feature = "serde", serde(skip_serializing_if = "Option::is_none"))]
    pub density: Option<Density>,
    /// What this adds to the pixel, without the vertices below; linear light.
    pub contribution: [f64; 3],
    /// Why its branch ends, or goes no further.
    pub why: String,
    /// The pass that cast the ray to it.
    pub cast: Step,
    /// The pass in which the ray's fate was decided; `None` if the history ends before it.
    pub decided: Option<Step>,
    /// The pass in which its branch ended.
    pub ended: Option<Step>,
}

impl Vertex {
    /// A vertex at a place in traced units, which the ray on its way reaches; it emits nothing.
    #[must_use]
    pub fn new(kind: VertexKind, place: Place) -> Self {
        Self {
            kind,
            parent: None,
            sample: 0,
            ray: "shadow",
            depth: 0,
            place,
            triangle: None,
            light: None,
            fate: Fate::Reached,
            arrives: None,
            throughput: None,
            density: None,
            contribution: [0.0; 3],
            why: String::new(),
            cast: Step::default(),
            decided: None,
            ended: None,
        }
    }

    /// What is there: `light 2`.
    #[must_use]
    pub fn object(&self) -> String {
        match (self.triangle, self.light) {
            (Some(triangle), _) => format!("triangle {triangle}"),
            (None, Some(light)) => format!("light {light}"),
            (None, None) => self.kind.name().into(),
        }
    }

    /// Whether a surface sent on the ray to it.
    #[must_use]
    pub fn is_sent_on(&self) -> bool {
        self.depth > 0 && self.kind != VertexKind::Light
    }

    /// Its name: what is there, after what became of the ray to it at a surface.
    #[must_use]
    pub fn name(&self) -> String {
        if self.is_sent_on() { format!("{}: {}", self.ray, self.object()) } else { self.object() }
    }
}

/// The light tree of a pixel.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct LightTree {
    /// Number of samples that a pixel of the run has.
    pub samples: u32,
    /// The vertices, in the order in which their rays were cast; a parent before those below it.
    pub vertices: Vec<Vertex>,
}

impl LightTree {
    /// The vertices as a tree is read: each before those below it. With how deep in the tree it is.
    #[must_use]
    pub fn in_order(&self) -> Vec<(usize, usize)> {
        let mut below = vec![Vec::new(); self.vertices.len()];
        let mut open: Vec<(usize, usize)> = Vec::new();
        for (i, vertex) in self.vertices.iter().enumerate().rev() {
            match vertex.parent.filter(|&parent| parent < i) {
                Some(parent) => below[parent].push(i),
                None => open.push((i, 0)),
            }
        }
        let mut order = Vec::with_capacity(self.vertices.len());
        while let Some((i, level)) = open.pop() {
            order.push((i, level));
            open.extend(below[i].iter().map(|&child| (child, level + 1)));
        }
        order
    }

    /// What every vertex adds to the pixel, with those below it.
    #[must_use]
    pub fn branches(&self) -> Vec<[f64; 3]> {
        let mut sums: Vec<[f64; 3]> = self.vertices.iter().map(|vertex| vertex.contribution).collect();
        for (i, vertex) in self.vertices.iter().enumerate().rev() {
            if let Some(parent) = vertex.parent.filter(|&parent| parent < i) {
                sums[parent] = added(sums[parent], sums[i]);
            }
        }
        sums
    }

    /// The sum of all contributions: the pixel's colour, up to rounding.
    #[must_use]
    pub fn sum(&self) -> [f64; 3] {
        self.vertices.iter().fold([0.0; 3], |sum, vertex| added(sum, vertex.contribution))
    }

    /// The vertex that the pass of a row is about: the ray to it is on its way, or its branch goes on.
    #[must_use]
    pub fn at_row(&self, row: usize) -> Option<usize> {
        let is_open = |vertex: &Vertex| vertex.ended.is_none_or(|end| row <= end.row);
        self.vertices.iter().rposition(|vertex| vertex.cast.row <= row && is_open(vertex))
    }
}

fn added(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [0, 1, 2].map(|c| a[c] + b[c])
}

/// Adds what a pass did to a pixel's light tree, from the ray before and after it.
pub type Grow = fn(&mut Grower, &SceneData, &RayState, &RayState);

/// A light tree while it grows. Places and light are given as the streams have them: in traced units, per sample.
#[derive(Clone, Debug)]
pub struct Grower {
    tree: LightTree,
    /// Scene units per traced unit.
    unit: f64,
    offset: [f64; 3],
    here: Step,
    /// The pass that cast the ray on its way, and what the ray is.
    cast: Step,
    ray: &'static str,
    sample: u32,
    /// The latest surface, and the ray that hit it.
    surface: Option<(usize, RayState)>,
}

impl Grower {
    /// An empty tree.
    #[must_use]
    pub fn new(data: &SceneData) -> Self {
        Self {
            tree: LightTree { samples: data.sampling.samples.max(1), vertices: Vec::new() },
            unit: data.units.scene_units_per_stream_unit(),
            offset: data.units.offset.to_array(),
            here: Step::default(),
            cast: Step::default(),
            ray: "camera",
            sample: 0,
            surface: None,
        }
    }

    /// What follows happens in this pass.
    pub fn go_to(&mut self, step: Step) {
        self.here = step;
    }

    /// A ray of a sample is on its way that began at the camera: the first time, the camera becomes a vertex.
    pub fn from_camera(&mut self, sample: u32, origin: [f32; 3]) {
        if self.tree.vertices.last().is_some_and(|last| last.sample == sample) {
            return;
        }
        self.sample = sample;
        self.surface = None;
        self.cast_ray("camera");
        let camera = Vertex::new(VertexKind::Camera, Place::Point(origin.map(f64::from)));
        self.add(Vertex { why: "not all of its light is known".into(), ..camera });
    }

    /// The pass casts a ray from a surface: the surface or background that it ends in begins here.
    pub fn cast_ray(&mut self, ray: &'static str) {
        (self.cast, self.ray) = (self.here, ray);
    }

    /// The latest surface, and the ray that hit it.
    #[must_use]
    pub fn surface(&self) -> Option<(usize, RayState)> {
        self.surface
    }

    /// Adds the surface that a ray hits.
    pub fn hit(&mut self, ray: &RayState, vertex: Vertex) {
        let why = "not all of its light is known".into();
        self.surface = Some((self.add(Vertex { why, ..vertex }), *ray));
    }

    /// Adds a vertex: a light below the latest surface; else below the latest surface that is one less deep, or the camera.
    pub fn add(&mut self, vertex: Vertex) -> usize {
        let (sample, depth) = (self.sample, vertex.depth);
        let is_above = |above: &Vertex| match (above.sample == sample, above.kind) {
            (true, VertexKind::Camera) => depth == 0,
            (true, VertexKind::Surface) => above.depth + 1 == depth,
            _ => false,
        };
        let (parent, cast) = match vertex.kind {
            VertexKind::Camera => (None, self.here),
            VertexKind::Light => (self.surface.map(|(surface, _)| surface), self.here),
            _ => (self.tree.vertices.iter().rposition(is_above), self.cast),
        };
        let (is_decided, is_leaf) = match vertex.kind {
            VertexKind::Camera | VertexKind::Surface => (true, false),
            VertexKind::Light | VertexKind::Background => (vertex.fate != Fate::Open, vertex.fate != Fate::Open),
        };
        let ray = if vertex.kind == VertexKind::Light { "shadow" } else { self.ray };
        let place = match vertex.place {
            Place::Point(point) => Place::Point(self.in_scene(point)),
            direction @ Place::Direction(_) => direction,
        };
        let contribution = self.share(vertex.contribution);
        let [decided, ended] = [is_decided, is_leaf].map(|is| is.then_some(self.here));
        self.tree.vertices.push(Vertex { parent, sample, ray, place, contribution, cast, decided, ended, ..vertex });
        self.tree.vertices.len() - 1
    }

    /// The ray to the latest vertex has met its fate; of an occluded one, the point is in traced units.
    pub fn decide(&mut self, fate: Fate, contribution: [f64; 3], why: String) {
        let contribution = self.share(contribution);
        let fate = match fate {
            Fate::Occluded { triangle, point_scene } => {
                Fate::Occluded { triangle, point_scene: self.in_scene(point_scene) }
            }
            other => other,
        };
        let here = Some(self.here);
        if let Some(vertex) = self.tree.vertices.last_mut().filter(|vertex| vertex.fate == Fate::Open) {
            *vertex = Vertex { fate, contribution, why, decided: here, ended: here, ..vertex.clone() };
        }
    }

    /// The branch of a vertex ends.
    pub fn end(&mut self, vertex: usize, why: &str) {
        let here = Some(self.here);
        if let Some(vertex) = self.tree.vertices.get_mut(vertex).filter(|vertex| vertex.ended.is_none()) {
            (vertex.ended, vertex.why) = (here, why.into());
        }
    }

    /// The sample is complete: its camera's branch ends.
    pub fn end_sample(&mut self) {
        let sample = self.sample;
        let is_camera = |vertex: &Vertex| vertex.sample == sample && vertex.kind == VertexKind::Camera;
        if let Some(camera) = self.tree.vertices.iter().rposition(is_camera) {
            self.end(camera, "all of its light is known");
        }
    }

    /// The tree; `None` if no ray has begun.
    #[must_use]
    pub fn finish(self) -> Option<LightTree> {
        (!self.tree.vertices.is_empty()).then_some(self.tree)
    }

    fn in_scene(&self, point: [f64; 3]) -> [f64; 3] {
        [0, 1, 2].map(|axis| point[axis] * self.unit + self.offset[axis])
    }

    fn share(&self, light: [f64; 3]) -> [f64; 3] {
        light.map(|c| c / f64::from(self.tree.samples))
    }
}
