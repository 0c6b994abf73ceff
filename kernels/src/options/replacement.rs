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

/// Why a file is no kernel.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum ReplacementError {
    /// It is too large.
    #[error("larger than 1 MiB, too large for a kernel")]
    Size,
    /// It is no text.
    #[error("not a text in UTF-8")]
    Text,
    /// It does not say which kernel it replaces.
    #[error("no @compute function tells which kernel it replaces: use --kernel NAME=FILE")]
    Nameless,
}

impl Replacement {
    /// Most bytes of a file: the longest kernel of ours has 10 KB.
    pub const MOST_BYTES: usize = 1 << 20;

    /// From a file's bytes, for the kernel with this name, or for the one that the file's first `@compute` function is named
    /// after.
    ///
    /// # Errors
    /// If it is no text, too large, or has neither.
    pub fn new(kernel: Option<String>, file: String, bytes: Vec<u8>) -> Result<Self, ReplacementError> {
        if bytes.len() > Self::MOST_BYTES {
            return Err(ReplacementError::Size);
        }
        let source = String::from_utf8(bytes).map_err(|_| ReplacementError::Text)?;
        let kernel = kernel.or_else(|| entry_point(&source)).ok_or(ReplacementError::Nameless)?;
        Ok(Self { kernel, file, source })
    }

    /// The file's own name, without folders.
    #[must_use]
    pub fn short_name(&self) -> &str {
        self.file.rsplit(['/', '\\']).next().unwrap_or(&self.file)
    }
}

/// The name of a text's first `@compute` function.
fn entry_point(source: &str) -> Option<String> {
    let code: Vec<&str> = source.lines().map(|line| line.split("//").next().unwrap_or_default()).collect();
    let code = code.join("\n");
    let (_, after) = code.split_once("@compute")?;
    let (_, name) = after.split_once("fn ")?;
    let name = name.trim_start();
    let name = &name[..name.find(|c: char| c != '_' && !c.is_alphanumeric())?];
    (!name.is_empty()).then(|| name.to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_names_its_kernel_unless_it_is_named() {
        let of = |name: Option<&str>, bytes: &[u8]| {
            Replacement::new(name.map(Into::into), "f".into(), bytes.into()).map(|own| own.kernel)
        };
        let text = b"// @compute fn no() {}\nfn a() {}\n@compute @workgroup_size(1) // fn or\nfn  yes_1(x: u32) {}";
        assert_eq!(of(None, text), Ok("yes_1".into()));
        assert_eq!(of(Some("other"), text), Ok("other".into()));
        assert_eq!(of(None, b"fn a() {}"), Err(ReplacementError::Nameless));
        assert_eq!(of(Some("a"), &[0xff]), Err(ReplacementError::Text));
        assert_eq!(of(Some("a"), &vec![b' '; Replacement::MOST_BYTES + 1]), Err(ReplacementError::Size));
    }
}
