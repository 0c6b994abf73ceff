//! The types of accessors' elements.

/// The type of a component.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Component {
    I8,
    U8,
    I16,
    U16,
    U32,
    F32,
}

impl Component {
    /// By the number in the file.
    pub(crate) fn by_code(code: u64) -> Option<Self> {
        Some(match code {
            5120 => Self::I8,
            5121 => Self::U8,
            5122 => Self::I16,
            5123 => Self::U16,
            5125 => Self::U32,
            5126 => Self::F32,
            _ => return None,
        })
    }

    pub(crate) fn bytes(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::U32 | Self::F32 => 4,
        }
    }

    /// What normalised integers are divided by.
    pub(super) fn scale(self) -> f64 {
        match self {
            Self::I8 => 127.0,
            Self::U8 => 255.0,
            Self::I16 => 32767.0,
            Self::U16 => 65535.0,
            Self::U32 => f64::from(u32::MAX),
            Self::F32 => 1.0,
        }
    }

    /// Reads one component.
    pub(super) fn read(self, bytes: &[u8]) -> f64 {
        match self {
            Self::I8 => i8::from_le_bytes(word(bytes)).into(),
            Self::U8 => u8::from_le_bytes(word(bytes)).into(),
            Self::I16 => i16::from_le_bytes(word(bytes)).into(),
            Self::U16 => u16::from_le_bytes(word(bytes)).into(),
            Self::U32 => u32::from_le_bytes(word(bytes)).into(),
            Self::F32 => f32::from_le_bytes(word(bytes)).into(),
        }
    }

    /// Reads one component of an unsigned type.
    pub(super) fn read_unsigned(self, bytes: &[u8]) -> u32 {
        match self.bytes() {
            1 => u8::from_le_bytes(word(bytes)).into(),
            2 => u16::from_le_bytes(word(bytes)).into(),
            _ => u32::from_le_bytes(word(bytes)),
        }
    }
}

/// The first `N` bytes; zeros past the end, which accessors' checks have excluded.
pub(super) fn word<const N: usize>(bytes: &[u8]) -> [u8; N] {
    bytes.first_chunk().copied().unwrap_or([0; N])
}

/// The type of an element.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Kind {
    Scalar,
    Vec2,
    Vec3,
    Vec4,
    Mat2,
    Mat3,
    Mat4,
}

impl Kind {
    pub(super) fn by_name(name: &str) -> Option<Self> {
        Some(match name {
            "SCALAR" => Self::Scalar,
            "VEC2" => Self::Vec2,
            "VEC3" => Self::Vec3,
            "VEC4" => Self::Vec4,
            "MAT2" => Self::Mat2,
            "MAT3" => Self::Mat3,
            "MAT4" => Self::Mat4,
            _ => return None,
        })
    }

    /// The number of components.
    pub(crate) fn components(self) -> usize {
        match self {
            Self::Scalar => 1,
            Self::Vec2 => 2,
            Self::Vec3 => 3,
            Self::Vec4 | Self::Mat2 => 4,
            Self::Mat3 => 9,
            Self::Mat4 => 16,
        }
    }
}
