//! `--kernel`: kernels whose WGSL is the user's.

use std::io::Read as _;
use std::path::PathBuf;
use std::str::FromStr;
use std::sync::Arc;

use clap::Args;
use raystep_kernels::options::replacement::Replacement;

use crate::error::Error;

/// Kernels to replace.
#[derive(Args, Clone, Debug, Default)]
pub(crate) struct KernelArgs {
    /// Replace a kernel by WGSL of your own; can be repeated. Without NAME=, the kernel that the file's @compute function is
    /// named after
    ///
    /// The file may import what the kernel's own file imports; 'raystep check-kernel' compares the two. Where options do not
    /// say otherwise, a run then takes single steps through the grid; 'raystep bench' measures the configurations that it is
    /// asked for. On the CPU, the file is interpreted.
    #[arg(long = "kernel", value_name = "[NAME=]F.wgsl", help_heading = "Tracing")]
    pub(crate) kernels: Vec<KernelFile>,
}

/// `NAME=FILE` or `FILE`
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct KernelFile {
    name: Option<String>,
    path: PathBuf,
}

impl FromStr for KernelFile {
    type Err = &'static str;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        let is_name = |name: &str| !name.is_empty() && name.chars().all(|c| c == '_' || c.is_ascii_alphanumeric());
        let (name, path) = match text.split_once('=') {
            Some((name, path)) if is_name(name) => (Some(name.to_owned()), path),
            _ => (None, text),
        };
        let path = PathBuf::from(path);
        if path.as_os_str().is_empty() {
            return Err("expected a kernel and a file, such as intersect=my.wgsl");
        }
        Ok(Self { name, path })
    }
}

impl KernelFile {
    /// A file for this kernel.
    pub(crate) fn new(name: Option<String>, path: PathBuf) -> Self {
        Self { name, path }
    }

    /// Its bytes: no more of them than show that it is too large.
    pub(crate) fn bytes(&self) -> std::io::Result<Vec<u8>> {
        let mut bytes = Vec::new();
        let most = Replacement::MOST_BYTES as u64 + 1;
        std::fs::File::open(&self.path)?.take(most).read_to_end(&mut bytes)?;
        Ok(bytes)
    }

    /// Reads the file.
    pub(crate) fn read(&self) -> Result<Arc<Replacement>, Error> {
        let at = |why: &dyn std::fmt::Display| Error::at(&self.path, why);
        let bytes = self.bytes().map_err(|e| at(&crate::error::reason(&e)))?;
        let path = self.path.to_string_lossy().into_owned();
        Replacement::new(self.name.clone(), path, bytes).map(Arc::new).map_err(|why| at(&why))
    }
}

impl KernelArgs {
    /// Refuses them where they would have no effect.
    pub(crate) fn refuse(&self, why: &str) -> Result<(), Error> {
        if self.kernels.is_empty() { Ok(()) } else { Err(Error::usage(format!("--kernel: {why}"))) }
    }

    /// Reads the files.
    pub(crate) fn read(&self) -> Result<Vec<Arc<Replacement>>, Error> {
        self.kernels.iter().map(KernelFile::read).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_kernel_is_a_name_and_a_file_or_a_file() {
        let of = |text: &str| text.parse::<KernelFile>();
        let file = |name: Option<&str>, path: &str| KernelFile { name: name.map(Into::into), path: path.into() };
        assert_eq!(of("intersect=my.wgsl"), Ok(file(Some("intersect"), "my.wgsl")));
        assert_eq!(of("my.wgsl"), Ok(file(None, "my.wgsl")));
        // A path may have an equals sign.
        assert_eq!(of("a/b=c.wgsl"), Ok(file(None, "a/b=c.wgsl")));
        assert_eq!(of("setup=b=c.wgsl"), Ok(file(Some("setup"), "b=c.wgsl")));
        assert!(of("setup=").is_err() && of("").is_err());
    }
}
