//! Every per-ray stream, in one table.
//!
//! ```text
//! ray_origin    f32  x  y  z             traced units
//! ray_direction f32  x  y  z             traced units per unit of t; not normalised
//! ray_interval  f32  t_min  t_max        t; hits count between the two
//! state         u32  tag  nearest-t  cell  item      while lights are summed, item is 2³¹ + their number
//! tmax          f32  x  y  z             t
//! control       f32  x  y  z             cells
//! voxel         u32  x  y  z             virtual cell by which the ray came into its cell
//! previous      u32  node                index of the BVH's previous node
//! hit           u32  u  v  triangle      u, v as f32 bits
//! bounds        f32  error  open         t; of the nearest hit, and the smallest t of what only integers can tell
//! color         f32  r  g  b             linear light
//! counters      u32  cells  triangles  repeated
//! accumulated   f32  r  g  b  a  samples mean of the block's samples so far, linear light; a: share that hit
//! blocks        f32  r  g  b  a          sum of the means of complete blocks of 16 samples
//! place         u32  x  y  z  left  tx  ty  tz   cell, cells still allowed, tmax or control (f32 bits)
//! trail         u32  levels 0, 8, 16, 24  4 bits per level
//! scan          u32  cell  tx  ty  tz    cell, tmax or control (f32 bits)
//! surface       u32  triangle            the triangle that the ray leaves, which it cannot hit again, or of the hit after which it
//!                                        looks for the next
//!
//! shadow_origin    f32  x  y  z          traced units: off the surface that was hit, on the side of the light
//! shadow_direction f32  x  y  z          traced units per unit of t: to the light, which is at t = 1
//! blocker          u32  u  v  triangle   what is between the hit and the light
//! shadow_counters  u32  cells  triangles  repeated
//! pending          f32  r  g  b          linear light that arrives if the light is visible
//! light            u32  next  t          the light that is next, and t of the hit (f32 bits)
//!
//! throughput f32  r  g  b                share of the light along the ray that reaches the pixel
//! radiance   f32  r  g  b                linear light that reaches the pixel, of all rays so far
//! bounce     u32  depth  waiting         reflections and refractions before the ray; bit d: a branch waits at depth d
//! branches   u32  x y z dx dy dz r g b triangle   for each depth: the refracted ray that waits (f32 bits), its
//!                                        throughput, and the triangle that it leaves
//! primary    u32  x y z dx dy dz t u v triangle   the pixel's first ray and its hit (f32 bits)
//! spent      u32  cells  triangles  repeated      counters of the rays before
//! pdf        f32  direction              pdf of the ray's direction, by solid angle; 0 from the camera, a mirror or glass
//! ended      u32  why                    why the path ended
//!
//! photon_origin … photon_trail           of photons: the same as of rays
//! photon_power   f32  r  g  b            what the photon carries, traced units squared times radiance
//! photon_energy  f32  emitted absorbed escaped, r g b each    what it carried at first, and what became of that
//! photon_bounce  u32  hits  specular  ended  emissions   hits before this one; whether all were on mirrors and glass; why it
//!                                        ended; how often it was emitted
//! photon_records u32  x y z dx dy dz r g b map ended   for each bounce: where the photon arrived, in which direction and with
//!                                        what (f32 bits); 0 global, 1 caustic, all ones: no photon; why it ended there
//! photon_key     u32  cell  record       of records: the cell, all ones without a photon, and which record
//! photon_first   u32  record             of cells: where the list of each begins among the sorted keys
//! gathering      u32  cell  item  end  found  sweep  map  sent  visited   of rays: how far the search for photons has got
//! gathered       f32  limit low high farthest r g b wr wg wb   bounds, squared, and sums of what was found
//! shrunk         f32  photons  squared   of rays, for each map, at what is seen and after a bounce: what iterations have left
//! ```
//!
//! The six from `shadow_origin` on, and the next eight, are those of the program [`light`](crate::programs::light), which has all others too. Its shadow rays
//! share `state` and what a walk keeps with the rays before them: a pixel's rays are traced one after the other. So are
//! those that surfaces reflect and refract, depth first: they are in `ray_origin`, `ray_direction` and `hit` in turn, and the
//! pixel's first ray and its hit are put back at the end.
//!
//! Lengths are in *traced units*: scene units times a power of two, see [`crate::numbers::units`]. `t` is the
//! parameter of `origin + t * direction`; a camera's direction has length 1 along the view axis, so t
//! of a primary ray is its depth.
//!
//! With the last three, a ray continues in the next dispatch if a walk or a search may take more loop iterations than
//! one dispatch allows (see [`crate::plan::Limits`]).
//!
//! With several samples per pixel, the rays of all samples use the same texels: all streams but `accumulated` and `blocks`
//! hold the values of the latest sample. At the end of a run, only `color` is replaced by the mean.

mod absent;
mod layers;

use super::elements::{
    ALL_RECORD_TALLIES, MAP_CELLS, PHOTONS, RAYS, RECORD_TALLIES, RECORD_TALLY_BLOCKS, RECORDS, no_map, no_photon_walk,
    no_scan,
};
use super::states::PHOTON_UNBORN;
use crate::options::features::Features;
use crate::options::reasons::{Because, EYE_RAYS, NO_SHADE, ONE_SAMPLE, On, Passes};
use crate::shared::constants::{INF, NO_CELL, NO_NODE, NO_TRIANGLE};
use crate::tables::stream::Meaning::{Count, Distance, Float, Id, Light, Tag};
use crate::tables::stream::{Stream, StreamInfo, streams};
use absent::{
    NO_WALK_WAITS, no_bounces, no_dielectric, no_iterations, no_path, no_shadow_counters, no_spent, of_bounds,
    of_control, of_photon_bounds, of_steps, of_surface, of_tmax,
};
pub(in crate::programs) use absent::{no_emitters, no_exact_order, no_shadows, no_specular};
use layers::{BRANCH_LAYERS, BRANCH_MEANING, RECORD_LAYERS, RECORD_MEANING, UNRECORDED};

/// Layer of the `state` stream: bits of the nearest t so far, [`INF`] without a hit.
pub const STATE_T: usize = 1;
/// Layer of the `state` stream: 1-D index of the cell, or index of the node.
pub const STATE_CELL: usize = 2;
/// Layer of the `state` stream: offset into the cell's or leaf's triangle list.
pub const STATE_ITEM: usize = 3;
/// Layer of the `hit` stream: the triangle, [`NO_TRIANGLE`] without a hit.
pub const HIT_TRIANGLE: usize = 2;
/// Layer of the `accumulated` stream: the samples so far, of all blocks; exact, as a float counts to 2²⁴.
pub const ACCUMULATED_SAMPLES: usize = 4;

/// The stream in which a walk through a uniform grid keeps what decides its next step.
#[must_use]
pub fn of_walk(features: &Features) -> Stream {
    if features.dda { CONTROL } else { TMAX }
}

/// The streams of the program `closest_hit`: all but those of shadow rays.
pub static OWN: &[StreamInfo] = STREAMS.split_at(SHADOW_ORIGIN.index()).0;
/// Those of the programs `light` and `path`: all but those of photons.
pub static OF_LIGHT: &[StreamInfo] = STREAMS.split_at(PHOTON_ORIGIN.index()).0;

streams! {
    /// Origin of the ray.
    RAY_ORIGIN of RAYS: "ray_origin" F32 &["x", "y", "z"], meaning: &[Float; 3], unit: "traced units",
        unwritten: &[0; 3], why_absent: |_| EYE_RAYS;
    /// Direction of the ray.
    RAY_DIRECTION of RAYS: "ray_direction" F32 &["x", "y", "z"], meaning: &[Float; 3], unit: "traced units per t",
        unwritten: &[0; 3], why_absent: |_| EYE_RAYS;
    /// The t between which hits count; neither end does.
    RAY_INTERVAL of RAYS: "ray_interval" F32 &["t_min", "t_max"], meaning: &[Distance; 2], unit: "t",
        unwritten: &[0, INF.to_bits()], why_absent: |_| (Because::Options, "needed only for rays with a t_min or a t_max");
    /// Tag, nearest t, cell, item offset.
    STATE of RAYS: "state" U32 &["tag", "t", "cell", "item"], meaning: &[Tag, Distance, Id, Count], unit: "tag, t as f32 bits, 1-D index, count",
        unwritten: &[0, INF.to_bits(), 0, 0], why_absent: of_steps;
    /// t at which the ray leaves its cell, per axis.
    TMAX of RAYS: "tmax" F32 &["x", "y", "z"], meaning: &[Distance; 3], unit: "t",
        unwritten: &[0; 3], why_absent: of_tmax;
    /// Of a 3D-DDA: how far the ray has gone past each axis's next face when it reaches that of its driving axis.
    CONTROL of RAYS: "control" F32 &["x", "y", "z"], meaning: &[Float; 3], unit: "cells along the axis",
        unwritten: &[0; 3], why_absent: of_control;
    /// Virtual cell of an irregular grid by which the ray came into its cell.
    VOXEL of RAYS: "voxel" U32 &["x", "y", "z"], meaning: &[Id; 3], unit: "coordinates of a virtual cell",
        unwritten: &[0; 3], why_absent: |run| run.needed_only(On::Irregular, Passes::Stepped);
    /// Node visited before this one.
    PREVIOUS of RAYS: "previous" U32 &["node"], meaning: &[Id], unit: "index of a node",
        unwritten: &[NO_NODE], why_absent: |run| run.needed_only(On::Bvh, Passes::Stepped);
    /// Barycentrics and triangle of the nearest hit.
    HIT of RAYS: "hit" U32 &["u", "v", "triangle"], meaning: &[Float, Float, Id], unit: "barycentric weights of vertices 1 and 2 as f32 bits, triangle id",
        unwritten: &[0, 0, NO_TRIANGLE], why_absent: of_steps;
    /// A bound on the error of the nearest hit's t, and the smallest t at which there may be another hit, which only integers can tell; -1 while a ray waits for these to go on.
    BOUNDS of RAYS: "bounds" F32 &["error", "open"], meaning: &[Distance; 2], unit: "t",
        unwritten: &[0, INF.to_bits()], why_absent: of_bounds;
    /// Shaded colour.
    COLOR of RAYS: "color" F32 &["r", "g", "b"], meaning: &[Light; 3], unit: "linear light",
        unwritten: &[0; 3], why_absent: |_| NO_SHADE;
    /// Cells visited, triangles tested, repeated tests.
    COUNTERS of RAYS: "counters" U32 &["cells", "triangles", "repeated"], meaning: &[Count; 3], unit: "count",
        unwritten: &[0; 3], why_absent: |_| (Because::Options, "needed only with --counters");
    /// Mean colour and coverage of the latest block's samples so far, and the number of all samples.
    ACCUMULATED of RAYS: "accumulated" F32 &["r", "g", "b", "a", "samples"], meaning: &[Light, Light, Light, Float, Float], unit: "linear light, share of samples that hit, count",
        unwritten: &[0; 5], why_absent: |_| ONE_SAMPLE;
    /// Sums over the complete blocks of samples of their means.
    BLOCKS of RAYS: "blocks" F32 &["r", "g", "b", "a"], meaning: &[Light, Light, Light, Float], unit: "linear light, share of samples that hit, times blocks",
        unwritten: &[0; 4], why_absent: |_| (Because::Options, "needed only with --spp 17 or more");
    /// Where in the grid a ray waits for the next dispatch of `fused`: what its cell's index does not tell.
    PLACE of RAYS: "place" U32 &["x", "y", "z", "left", "tmax_x", "tmax_y", "tmax_z"], meaning: &[Id, Id, Id, Count, Distance, Distance, Distance], unit: "cell coordinates, count of cells, t or control terms as f32 bits",
        unwritten: &[0; 7], why_absent: |_| NO_WALK_WAITS;
    /// Where in the wide BVH a ray waits for the next dispatch: the child entered last on each level.
    TRAIL of RAYS: "trail" U32 &["levels_0", "levels_8", "levels_16", "levels_24"], meaning: &[Id; 4], unit: "child entered last, 4 bits per level",
        unwritten: &[0; 4], why_absent: |_| NO_WALK_WAITS;
    /// Where the search for repeated tests waits for the next dispatch.
    SCAN of RAYS: "scan" U32 &["cell", "tmax_x", "tmax_y", "tmax_z"], meaning: &[Id, Distance, Distance, Distance], unit: "1-D index, t or control terms as f32 bits",
        unwritten: &[NO_CELL, 0, 0, 0], why_absent: |_| (Because::Options, "needed only if a search for repeated tests may take more loop turns than one dispatch allows");
    /// The triangle that the ray leaves, or of the hit after which it looks for the next.
    SURFACE of RAYS: "surface" U32 &["triangle"], meaning: &[Id], unit: "triangle id",
        unwritten: &[NO_TRIANGLE], why_absent: of_surface;
    /// Origin of the shadow ray.
    SHADOW_ORIGIN of RAYS: "shadow_origin" F32 &["x", "y", "z"], meaning: &[Float; 3], unit: "traced units",
        unwritten: &[0; 3], why_absent: no_shadows;
    /// Direction of the shadow ray: to a light at t = 1, or against that in which a directional light shines.
    SHADOW_DIRECTION of RAYS: "shadow_direction" F32 &["x", "y", "z"], meaning: &[Float; 3], unit: "traced units per t",
        unwritten: &[0; 3], why_absent: no_shadows;
    /// Barycentrics and triangle of what occludes the latest shadow ray: any hit, not the nearest.
    BLOCKER of RAYS: "blocker" U32 &["u", "v", "triangle"], meaning: &[Float, Float, Id], unit: "barycentric weights of vertices 1 and 2 as f32 bits, triangle id",
        unwritten: &[0, 0, NO_TRIANGLE], why_absent: no_shadows;
    /// Cells visited and triangles tested by the latest shadow ray.
    SHADOW_COUNTERS of RAYS: "shadow_counters" U32 &["cells", "triangles", "repeated"], meaning: &[Count; 3], unit: "count",
        unwritten: &[0; 3], why_absent: no_shadow_counters;
    /// The light that arrives if the shadow ray reaches its light.
    PENDING of RAYS: "pending" F32 &["r", "g", "b"], meaning: &[Light; 3], unit: "linear light",
        unwritten: &[0; 3], why_absent: no_shadows;
    /// Which light is next, and t of the hit while `state` has that of the shadow ray.
    LIGHT of RAYS: "light" U32 &["next", "t"], meaning: &[Count, Distance], unit: "count, t as f32 bits",
        unwritten: &[0, INF.to_bits()], why_absent: no_shadows;
    /// The share of the light along the ray that reaches the pixel.
    THROUGHPUT of RAYS: "throughput" F32 &["r", "g", "b"], meaning: &[Light; 3], unit: "share of linear light",
        unwritten: &[0; 3], why_absent: no_bounces;
    /// The light that reaches the pixel by all of its rays so far.
    RADIANCE of RAYS: "radiance" F32 &["r", "g", "b"], meaning: &[Light; 3], unit: "linear light",
        unwritten: &[0; 3], why_absent: no_bounces;
    /// How many surfaces have reflected or refracted the ray, and at which depths another ray waits.
    BOUNCE of RAYS: "bounce" U32 &["depth", "waiting"], meaning: &[Count, Count], unit: "count, one bit for each depth",
        unwritten: &[0; 2], why_absent: no_bounces;
    /// At each depth, the refracted ray that waits while the reflected one is traced.
    BRANCHES of RAYS: "branches" U32 BRANCH_LAYERS, meaning: &BRANCH_MEANING, unit: "traced units, traced units per t, share of linear light, as f32 bits; triangle id",
        unwritten: &[0; BRANCH_LAYERS.len()], why_absent: no_dielectric;
    /// The pixel's first ray and its hit, while others are traced.
    PRIMARY of RAYS: "primary" U32 &["x", "y", "z", "dx", "dy", "dz", "t", "u", "v", "triangle"], meaning: &[Float, Float, Float, Float, Float, Float, Distance, Float, Float, Id], unit: "traced units, traced units per t, t, barycentric weights, as f32 bits; triangle id",
        unwritten: &[0, 0, 0, 0, 0, 0, INF.to_bits(), 0, 0, NO_TRIANGLE], why_absent: no_bounces;
    /// Cells visited, triangles tested, repeated tests of the pixel's rays before this one.
    SPENT of RAYS: "spent" U32 &["cells", "triangles", "repeated"], meaning: &[Count; 3], unit: "count",
        unwritten: &[0; 3], why_absent: no_spent;
    /// The pdf of the ray's direction by solid angle; 0 if no other direction was possible.
    PDF of RAYS: "pdf" F32 &["direction"], meaning: &[Float], unit: "per steradian",
        unwritten: &[0], why_absent: no_path;
    /// Why the pixel's latest path ended.
    ENDED of RAYS: "ended" U32 &["why"], meaning: &[Id], unit: "1 nothing was hit, 2 depth, 3 absorbed, 4 below the surface, 5 by chance, 6 photons were gathered",
        unwritten: &[0], why_absent: no_path;
    /// Origin of the photon's way.
    PHOTON_ORIGIN of PHOTONS: "photon_origin" F32 &["x", "y", "z"], meaning: &[Float; 3], unit: "traced units",
        unwritten: &[0; 3], why_absent: no_map;
    /// Its direction.
    PHOTON_DIRECTION of PHOTONS: "photon_direction" F32 &["x", "y", "z"], meaning: &[Float; 3], unit: "traced units per t",
        unwritten: &[0; 3], why_absent: no_map;
    /// Tag, nearest t, cell, item offset.
    PHOTON_STATE of PHOTONS: "photon_state" U32 &["tag", "t", "cell", "item"], meaning: &[Tag, Distance, Id, Count], unit: "tag, t as f32 bits, 1-D index, count",
        unwritten: &[PHOTON_UNBORN, INF.to_bits(), 0, 0], why_absent: no_map;
    /// t at which the photon leaves its cell, per axis.
    PHOTON_TMAX of PHOTONS: "photon_tmax" F32 &["x", "y", "z"], meaning: &[Distance; 3], unit: "t",
        unwritten: &[0; 3], why_absent: no_photon_walk;
    /// Of a 3D-DDA: as of a ray.
    PHOTON_CONTROL of PHOTONS: "photon_control" F32 &["x", "y", "z"], meaning: &[Float; 3], unit: "cells along the axis",
        unwritten: &[0; 3], why_absent: no_photon_walk;
    /// Virtual cell of an irregular grid by which the photon came into its cell.
    PHOTON_VOXEL of PHOTONS: "photon_voxel" U32 &["x", "y", "z"], meaning: &[Id; 3], unit: "coordinates of a virtual cell",
        unwritten: &[0; 3], why_absent: no_photon_walk;
    /// Node visited before this one.
    PHOTON_PREVIOUS of PHOTONS: "photon_previous" U32 &["node"], meaning: &[Id], unit: "index of a node",
        unwritten: &[NO_NODE], why_absent: no_photon_walk;
    /// Barycentrics and triangle of the nearest hit.
    PHOTON_AT of PHOTONS: "photon_at" U32 &["u", "v", "triangle"], meaning: &[Float, Float, Id], unit: "barycentric weights of vertices 1 and 2 as f32 bits, triangle id",
        unwritten: &[0, 0, NO_TRIANGLE], why_absent: no_map;
    /// Of the nearest hit, as of a ray's.
    PHOTON_BOUNDS of PHOTONS: "photon_bounds" F32 &["error", "open"], meaning: &[Distance; 2], unit: "t",
        unwritten: &[0, INF.to_bits()], why_absent: of_photon_bounds;
    /// The triangle that the photon leaves.
    PHOTON_SURFACE of PHOTONS: "photon_surface" U32 &["triangle"], meaning: &[Id], unit: "triangle id",
        unwritten: &[NO_TRIANGLE], why_absent: no_map;
    /// Where in the grid a photon waits for the next dispatch: as of a ray.
    PHOTON_PLACE of PHOTONS: "photon_place" U32 &["x", "y", "z", "left", "tmax_x", "tmax_y", "tmax_z"], meaning: &[Id, Id, Id, Count, Distance, Distance, Distance], unit: "cell coordinates, count of cells, t or control terms as f32 bits",
        unwritten: &[0; 7], why_absent: no_photon_walk;
    /// Where in the wide BVH a photon waits for the next dispatch: as of a ray.
    PHOTON_TRAIL of PHOTONS: "photon_trail" U32 &["levels_0", "levels_8", "levels_16", "levels_24"], meaning: &[Id; 4], unit: "child entered last, 4 bits per level",
        unwritten: &[0; 4], why_absent: no_photon_walk;
    /// What the photon carries.
    PHOTON_POWER of PHOTONS: "photon_power" F32 &["r", "g", "b"], meaning: &[Light; 3], unit: "radiance times steradians and traced units squared",
        unwritten: &[0; 3], why_absent: no_map;
    /// What it carried at first, and what surfaces and the outside have of that.
    PHOTON_ENERGY of PHOTONS: "photon_energy" F32 &["emitted_r", "emitted_g", "emitted_b", "absorbed_r", "absorbed_g", "absorbed_b", "escaped_r", "escaped_g", "escaped_b"], meaning: &[Float; 9], unit: "as photon_power",
        unwritten: &[0; 9], why_absent: no_map;
    /// Hits before, whether all were on mirrors and glass, why it ended, and how often it has been emitted.
    PHOTON_BOUNCE of PHOTONS: "photon_bounce" U32 &["hits", "specular", "ended", "emissions"], meaning: &[Count, Id, Id, Count], unit: "count, 1 if all were on mirrors and glass, 1 nothing was hit, 2 depth, 3 absorbed, 4 below the surface, 5 by chance, count",
        unwritten: &[0, 1, 0, 0], why_absent: no_map;
    /// At each bounce, where the photon arrived on a diffuse surface, and what became of it.
    PHOTON_RECORDS of PHOTONS: "photon_records" U32 RECORD_LAYERS, meaning: &RECORD_MEANING, unit: "traced units, direction, power, as f32 bits; 0 global, 1 caustic, all ones without a photon; why it ended there",
        unwritten: &UNRECORDED, why_absent: no_map;
    /// A record's cell, and which record it is; sorted in place.
    PHOTON_KEY of RECORDS: "photon_key" U32 &["cell", "record"], meaning: &[Id; 2], unit: "1-D index of a cell, index of a record",
        unwritten: &[NO_CELL, 0], why_absent: no_map;
    /// The same, sorted by an odd number of digits.
    PHOTON_KEY_THERE of RECORDS: "photon_key_there" U32 &["cell", "record"], meaning: &[Id; 2], unit: "1-D index of a cell, index of a record",
        unwritten: &[NO_CELL, 0], why_absent: no_scan;
    /// The cells alone, as the shared kernels write them.
    PHOTON_CELL of RECORDS: "photon_cell" U32 &["cell"], meaning: &[Id], unit: "1-D index of a cell",
        unwritten: &[NO_CELL], why_absent: no_scan;
    /// How often a digit occurs in a block of records; after the scan, where the first of these goes.
    PHOTON_TALLY of RECORD_TALLIES: "photon_tally" U32 &["records"], meaning: &[Count], unit: "count of records",
        unwritten: &[0], why_absent: no_scan;
    /// Number of records of a block of tallies.
    PHOTON_TALLY_OF_BLOCK of RECORD_TALLY_BLOCKS: "photon_tally_of_block" U32 &["records"], meaning: &[Count], unit: "count of records",
        unwritten: &[0], why_absent: no_scan;
    /// Number of records of all tallies.
    PHOTON_TALLY_IN_ALL of ALL_RECORD_TALLIES: "photon_tally_in_all" U32 &["records"], meaning: &[Count], unit: "count of records",
        unwritten: &[0], why_absent: no_scan;
    /// Where a cell's list begins; of the one after the last, where all lists end.
    PHOTON_FIRST of MAP_CELLS: "photon_first" U32 &["record"], meaning: &[Count], unit: "index of a sorted record",
        unwritten: &[0], why_absent: no_map;
    /// How far the search for the photons near a hit has got.
    GATHERING of RAYS: "gathering" U32 &["cell", "item", "end", "found", "sweep", "map", "sent", "visited"], meaning: &[Id, Id, Id, Count, Count, Id, Id, Id], unit: "which of the cells around, index of a sorted record, count of photons, count of searches, 0 global or 1 caustic, 1 after a diffuse bounce, a bit for each of the cells around",
        unwritten: &[NO_CELL, 0, 0, 0, 0, 0, 0, 0], why_absent: no_map;
    /// What it has found.
    GATHERED_POWER of RAYS: "gathered" F32 &["limit", "low", "high", "farthest", "r", "g", "b", "weighted_r", "weighted_g", "weighted_b"], meaning: &[Float; 10], unit: "traced units squared; sums of photon_power, and of it times the distance",
        unwritten: &[0; 10], why_absent: no_map;
    /// What iterations have left of the photons found and of the squared radius: of a place that is seen in the global map and in that of caustics, and of one beyond a diffuse surface.
    SHRUNK of RAYS: "shrunk" F32 &["photons_global", "squared_global", "photons_caustic", "squared_caustic", "photons_global_sent", "squared_global_sent", "photons_caustic_sent", "squared_caustic_sent"], meaning: &[Float; 8], unit: "count of photons, traced units squared",
        unwritten: &[0; 8], why_absent: no_iterations;
}

/// The streams in which the caller supplies rays, as far as a run has them.
pub static INPUTS: [Stream; 4] = [RAY_ORIGIN, RAY_DIRECTION, RAY_INTERVAL, STATE];
/// The same of rays whose hits are all wanted.
pub static INPUTS_OF_ALL: [Stream; 5] = [RAY_ORIGIN, RAY_DIRECTION, RAY_INTERVAL, STATE, SURFACE];
