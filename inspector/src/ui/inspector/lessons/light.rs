//! The values of a pixel's light tree.

use raystep_kernels::export::light_tree::{Fate, LightTree, Place, Vertex, VertexKind};
use raystep_kernels::export::trace::Trace;
use raystep_kernels::numbers::real::Vec3;
use raystep_kernels::program::ray_state::Bounce;
use raystep_kernels::shared::emitters::LUMINANCE;
use raystep_kernels::shared::shading::Material;
use raystep_kernels::shared::vector::{cross3, dot3};

use crate::lesson::{Fact, Value};
use crate::session::request::Opened;

/// The tree of the selected pixel.
pub(super) struct Light<'a> {
    opened: &'a Opened,
    history: &'a Trace,
    tree: LightTree,
}

impl<'a> Light<'a> {
    /// An error says why there is none.
    pub(super) fn of(history: &'a Trace, opened: &'a Opened) -> Result<Self, String> {
        let tree = LightTree::of(&history.rows, opened.plan.program, &opened.data);
        Ok(Self { opened, history, tree: tree.ok_or("no ray leaves a hit in this run")? })
    }

    pub(super) fn fact(&self, fact: Fact) -> Result<Value, String> {
        let vertices = &self.tree.vertices;
        let cast = || vertices.iter().filter(|vertex| vertex.parent.is_some() && vertex.fate != Fate::NotCast);
        let shadows = || cast().filter(|vertex| vertex.kind == VertexKind::Light);
        Ok(match fact {
            Fact::LightAdds => Value::small(mean(self.tree.sum())),
            Fact::LightRays => Value::count(cast().count() as u64),
            Fact::LightShadows => Value::count(shadows().count() as u64),
            Fact::LightReached => Value::count(shadows().filter(|vertex| vertex.fate == Fate::Reached).count() as u64),
            Fact::LightDepth => Value::count(cast().map(|vertex| u64::from(vertex.depth)).max().unwrap_or(0)),
            _ => {
                let all = mean(self.tree.sum());
                let most = vertices.iter().map(|vertex| mean(vertex.contribution)).fold(0.0, f64::max);
                if all > 0.0 { Value::share(most / all) } else { return Err("no light arrives at this pixel".into()) }
            }
        })
    }

    /// Of the vertex that a row of the history decides, or else belongs to.
    pub(super) fn of_vertex(&self, fact: Fact, row: usize) -> Result<Value, String> {
        let is_decided = |vertex: &Vertex| vertex.decided.is_some_and(|step| step.row == row);
        let found = self.tree.vertices.iter().rposition(is_decided).or_else(|| self.tree.at_row(row));
        let vertex = found.and_then(|i| self.tree.vertices.get(i)).ok_or("this pass belongs to no vertex")?;
        let arrives = || vertex.arrives.map_or(0.0, |rgb| mean(rgb.map(f64::from)));
        Ok(match fact {
            Fact::VertexName => Value::text(vertex.name()),
            Fact::VertexSample => Value::count(u64::from(vertex.sample) + 1),
            Fact::VertexDepth => Value::count(vertex.depth.into()),
            Fact::VertexAdds => Value::small(mean(vertex.contribution)),
            Fact::VertexArrives => Value::small(arrives()),
            Fact::VertexThroughput => Value::small(mean(self.bounce(vertex)?.throughput.map(f64::from))),
            Fact::VertexPdf => Value::small(self.pdf(vertex)?),
            Fact::VertexLightPdf => Value::small(self.light_pdf(vertex)?),
            _ => Value::small(arrives() / mean(self.material(vertex)?.1.emissive.map(f64::from))),
        })
    }

    /// What the ray to a vertex carries.
    fn bounce(&self, vertex: &Vertex) -> Result<Bounce, String> {
        let row = self.history.rows.get(vertex.cast.row);
        row.and_then(|row| row.after.bounce).ok_or_else(|| "no surface sent on the ray to it".into())
    }

    /// The pdf of the direction to a vertex.
    fn pdf(&self, vertex: &Vertex) -> Result<f64, String> {
        let pdf = if vertex.is_sent_on() { self.bounce(vertex)?.pdf } else { 0.0 };
        if pdf > 0.0 { Ok(pdf.into()) } else { Err("the direction to it was not random".into()) }
    }

    /// A triangle that glows, and its material.
    fn material(&self, vertex: &Vertex) -> Result<(u32, &Material), String> {
        let data = &self.opened.data;
        let of = |triangle: u32| {
            let material = data.materials.get(*data.triangle_materials.get(triangle as usize)? as usize)?;
            (material.emissive != [0.0; 3]).then_some((triangle, material))
        };
        let found = vertex.triangle.filter(|_| vertex.kind == VertexKind::Surface).and_then(of);
        found.ok_or_else(|| "it is not a surface that glows".into())
    }

    /// The pdf, by solid angle, by which a surface that glows is found when a light is picked.
    fn light_pdf(&self, vertex: &Vertex) -> Result<f64, String> {
        let data = &self.opened.data;
        let (triangle, material) = self.material(vertex)?;
        let parent = vertex.parent.and_then(|parent| self.tree.vertices.get(parent));
        let (Some(Place::Point(from)), Place::Point(to)) = (parent.map(|parent| parent.place), vertex.place) else {
            return Err("the ray to it comes from no point".into());
        };
        let of_area = f64::from(data.emission.per_luminance);
        if of_area == 0.0 {
            return Err("no light is picked with this strategy".into());
        }
        let unit = data.units.scene_units_per_stream_unit();
        let [x, y, z] = [0, 1, 2].map(|axis| (to[axis] - from[axis]) / unit);
        let way = Vec3::new(x, y, z);
        let [a, b, c] = data.corners::<f64>(triangle);
        let normal = cross3(b - a, c - a);
        let length = |v: Vec3<f64>| dot3(v, v).sqrt();
        let cosine = dot3(normal, way).abs() / (length(normal) * length(way));
        let luminance: f64 = (0..3).map(|c| f64::from(material.emissive[c]) * f64::from(LUMINANCE[c])).sum();
        let sides = if material.double_sided == 0 { 1.0 } else { 2.0 };
        Ok(luminance * of_area * sides * dot3(way, way) / cosine)
    }
}

fn mean(rgb: [f64; 3]) -> f64 {
    rgb.iter().sum::<f64>() / 3.0
}
