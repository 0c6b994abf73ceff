//! What this program traces.

use crate::tables::elements::{Count, Elements};

/// A ray for each pixel, or for each ray that is given.
pub static RAYS: Elements = Elements { name: "rays", count: Count::Image };
