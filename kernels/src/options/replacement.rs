//! WGSL of a user's that takes the place of a kernel.

/// A kernel's WGSL from outside: `--kernel NAME=FILE`. It may import what the kernel's own file may.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct Replacement {
    /// The kernel's name in the program.
    pub kernel: String,
    /// What the user calls the file, for messages.
    pub file: String,
    /// The WGSL.
    pub source: String,
}

impl Replacement {
    /// Of the kernel that the file's first `@compute` function is named after; `None` if it has none.
    #[must_use]
    pub fn of_entry_point(file: String, source: String) -> Option<Self> {
        let (_, after) = source.split_once("@compute")?;
        let (_, name) = after.split_once("fn ")?;
        let end = name.find(|c: char| c != '_' && !c.is_alphanumeric())?;
        let kernel = name[..end].to_owned();
        (!kernel.is_empty()).then_some(Self { kernel, file, source })
    }

    /// The file's own name, without folders.
    #[must_use]
    pub fn short_name(&self) -> &str {
        self.file.rsplit(['/', '\\']).next().unwrap_or(&self.file)
    }
}
