//! What light a pixel receives, and how it is found.

use crate::numbers::named::named;

/// What light the colour of a ray consists of.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Integrator {
    /// The paper's equation (1) at the hit: all lights count, also those that do not reach it.
    #[default]
    Local,
    /// The same, but a light counts only if a shadow ray reaches it: the shadow caster of Purcell et al. (2002).
    Shadows,
    /// The same, and what mirrors reflect and transparent surfaces reflect and refract (Whitted, 1980).
    Whitted,
    /// Light along random paths, in physical units (Kajiya, 1986).
    Path,
    /// Light that photons carried to surfaces near what is seen: photon maps (Jensen, 1996; Purcell et al., 2003).
    Photons,
}

impl Integrator {
    /// Whether light is in physical units, and found from what gives it.
    #[must_use]
    pub fn is_physical(self) -> bool {
        matches!(self, Self::Path | Self::Photons)
    }
}

/// How a path finds light.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Strategy {
    /// By both of the others, each weighted by its pdf (Veach and Guibas, 1995).
    #[default]
    Mis,
    /// By picking a light, or a point of a surface that glows, at each bounce.
    Light,
    /// By chance, where the path hits it; only lights without a size are picked.
    Bsdf,
}

/// What a path sees that leaves the scene: an environment of constant radiance.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Environment {
    /// The background of every picture, which is nearly black; white if nothing in the scene gives light.
    #[default]
    Auto,
    /// Nothing.
    Black,
    /// A radiance of 1 from everywhere.
    White,
}

named!(
    Integrator,
    "local, shadows, whitted, path, photons",
    Local "local",
    Shadows "shadows",
    Whitted "whitted",
    Path "path",
    Photons "photons"
);
named!(Environment, "auto, black, white", Auto "auto", Black "black", White "white");
named!(Strategy, "mis, light, bsdf", Mis "mis", Light "light", Bsdf "bsdf");

/// Default number of times that a ray is reflected or refracted.
pub const MAX_DEPTH: u32 = 5;

/// Most of them with a tree of rays, where a pixel keeps a ray for each, or with photons, which are stored at each.
pub const MOST_DEPTH: u32 = 8;

/// Most bounces of a path.
pub const MOST_BOUNCES: u32 = 64;
