//! The types of accessors' elements.

use gltf::json::accessor::ComponentType;

/// What normalised integers are divided by.
pub(super) fn scale(component: ComponentType) -> f64 {
    match component {
        ComponentType::I8 => 127.0,
        ComponentType::U8 => 255.0,
        ComponentType::I16 => 32767.0,
        ComponentType::U16 => 65535.0,
        ComponentType::U32 => f64::from(u32::MAX),
        ComponentType::F32 => 1.0,
    }
}

/// Reads one component.
pub(super) fn read(component: ComponentType, bytes: &[u8]) -> f64 {
    match component {
        ComponentType::I8 => i8::from_le_bytes(word(bytes)).into(),
        ComponentType::U8 => u8::from_le_bytes(word(bytes)).into(),
        ComponentType::I16 => i16::from_le_bytes(word(bytes)).into(),
        ComponentType::U16 => u16::from_le_bytes(word(bytes)).into(),
        ComponentType::U32 => u32::from_le_bytes(word(bytes)).into(),
        ComponentType::F32 => f32::from_le_bytes(word(bytes)).into(),
    }
}

/// Reads one component of an unsigned type.
pub(super) fn read_unsigned(component: ComponentType, bytes: &[u8]) -> u32 {
    match component.size() {
        1 => u8::from_le_bytes(word(bytes)).into(),
        2 => u16::from_le_bytes(word(bytes)).into(),
        _ => u32::from_le_bytes(word(bytes)),
    }
}

/// The first `N` bytes; zeros past the end, which accessors' checks have excluded.
pub(super) fn word<const N: usize>(bytes: &[u8]) -> [u8; N] {
    bytes.first_chunk().copied().unwrap_or([0; N])
}
