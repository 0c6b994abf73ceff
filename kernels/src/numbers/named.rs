//! Enums whose values have names in options, links and reports.

/// A value that an option does not have.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{value:?} is not one of {expected}")]
pub struct ParseOptionError {
    value: String,
    expected: &'static str,
}

impl ParseOptionError {
    /// `expected` lists the possible values.
    #[must_use]
    pub fn new(value: &str, expected: &'static str) -> Self {
        Self { value: value.into(), expected }
    }
}

/// Names an enum's values: lists them, and with a list of the names for errors, also reads them, for people and for serde.
#[doc(hidden)]
#[macro_export]
macro_rules! named {
    ($type:ident, $expected:literal, $($variant:ident $name:literal),*) => {
        impl $type {
            /// Every value.
            pub const ALL: &[Self] = &[$(Self::$variant),*];
            /// Its name in options and reports.
            #[must_use]
            pub fn name(self) -> &'static str {
                match self { $(Self::$variant => $name),* }
            }
        }
        impl std::fmt::Display for $type {
            fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
                f.write_str(self.name())
            }
        }
        impl std::str::FromStr for $type {
            type Err = $crate::numbers::named::ParseOptionError;
            fn from_str(value: &str) -> Result<Self, Self::Err> {
                match value {
                    $($name => Ok(Self::$variant),)*
                    _ => Err($crate::numbers::named::ParseOptionError::new(value, $expected)),
                }
            }
        }
        $crate::named_serde!($type);
    };
    ($type:ident, $($variant:ident $name:literal),*) => {
        impl $type {
            /// Every value.
            pub const ALL: [Self; [$($name),*].len()] = [$(Self::$variant),*];
            /// Its name for people, and in tables.
            #[must_use]
            pub fn name(self) -> &'static str {
                match self { $(Self::$variant => $name),* }
            }
        }
    };
}
pub(crate) use named;

/// What [`named`] adds with the feature `serde` of this crate, not of the crate that uses the macro.
#[cfg(feature = "serde")]
#[doc(hidden)]
#[macro_export]
macro_rules! named_serde {
    ($type:ident) => {
        impl serde::Serialize for $type {
            fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
                serializer.serialize_str(self.name())
            }
        }
        impl<'de> serde::Deserialize<'de> for $type {
            fn deserialize<D: serde::Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
                let name = <std::borrow::Cow<'_, str>>::deserialize(deserializer)?;
                name.parse().map_err(serde::de::Error::custom)
            }
        }
    };
}

/// Nothing, without the feature `serde`.
#[cfg(not(feature = "serde"))]
#[doc(hidden)]
#[macro_export]
macro_rules! named_serde {
    ($type:ident) => {};
}
