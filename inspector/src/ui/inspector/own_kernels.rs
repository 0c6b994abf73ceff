//! Kernels that a user replaces: their files are read when they are opened or dropped, and again whenever they are written.

use std::sync::Arc;

use raystep_kernels::options::replacement::Replacement;

use crate::session::request::Request;
use crate::settings::Settings;
use crate::ui::Inspector;

/// The ending of a kernel's file.
pub(super) const ENDING: &str = ".wgsl";

/// Largest file of a kernel.
const MOST_BYTES: usize = 1 << 20;

/// Whether a path is that of a kernel.
pub(super) fn is_kernel(path: &str) -> bool {
    path.to_ascii_lowercase().ends_with(ENDING)
}

impl Inspector {
    /// A kernel's file was read: the run is made again with it, at the same place. Until that succeeds, the present run goes
    /// on.
    pub(in crate::ui) fn take_kernel(&mut self, path: &str, bytes: &[u8]) {
        let source = match std::str::from_utf8(bytes) {
            Ok(source) if bytes.len() <= MOST_BYTES => source,
            Ok(_) => return self.refuse_kernel(format!("{path}: larger than 1 MiB, too large for a kernel")),
            Err(_) => return self.refuse_kernel(format!("{path}: not a text in UTF-8")),
        };
        let Some(settings) = self.model.opened.as_ref().map(|opened| opened.settings.clone()) else {
            return self.fail(format!("{path}: open a scene first, then the kernel"));
        };
        // The name that the command line gave it, or that of its entry point.
        let known = settings.replaced.iter().find(|own| own.file == path).map(|own| own.kernel.clone());
        let own = match known {
            Some(kernel) => Some(Replacement { kernel, file: path.to_owned(), source: source.to_owned() }),
            None => Replacement::of_entry_point(path.to_owned(), source.to_owned()),
        };
        let Some(own) = own else {
            return self.refuse_kernel(format!("{path}: it has no @compute function named after a kernel"));
        };
        self.host.watch(path);
        if settings.replaced.iter().any(|before| **before == own) && self.state.display.kernel_error.is_none() {
            return;
        }
        let mut settings = settings;
        settings.replaced.retain(|other| other.kernel != own.kernel);
        settings.replaced.push(Arc::new(own));
        self.plan(settings);
    }

    /// Runs our own kernels again.
    pub(super) fn use_built_in_kernels(&mut self) {
        let Some(opened) = &self.model.opened else { return };
        let settings = Settings { replaced: Vec::new(), ..opened.settings.clone() };
        self.state.display.kernel_error = None;
        self.model.ask(Request::Plan(Box::new(settings)));
    }

    fn refuse_kernel(&mut self, why: String) {
        self.state.display.kernel_error = Some(why.clone());
        self.fail(why);
    }

    /// Watches the files of the kernels that a run was opened with.
    pub(super) fn watch_kernels(&mut self) {
        let Some(opened) = &self.model.opened else { return };
        let files: Vec<String> = opened.settings.replaced.iter().map(|own| own.file.clone()).collect();
        files.iter().for_each(|file| self.host.watch(file));
    }

    /// Whether a kernel is a user's, or is to be one.
    pub(super) fn has_own_kernels(&self) -> bool {
        self.state.display.kernel_error.is_some()
            || self.model.opened.as_ref().is_some_and(|opened| !opened.settings.replaced.is_empty())
    }
}
