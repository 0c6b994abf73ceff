//! The elements of this program.

use crate::tables::elements::{Count, Elements};

/// One ray per pixel, or per input ray.
pub static RAYS: Elements = Elements { name: "rays", count: Count::Image };
