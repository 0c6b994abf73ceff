//! Kernels that a user replaces: their files are read when they are opened or dropped, and again whenever they are written.

use std::sync::Arc;

use raystep_kernels::options::replacement::Replacement;

use crate::session::request::Request;
use crate::settings::Settings;
use crate::ui::Inspector;

impl Inspector {
    /// A kernel's file was read: the run is made again with it, at the same place. Until that succeeds, the present run goes
    /// on.
    pub(in crate::ui) fn take_kernel(&mut self, path: &str, bytes: Vec<u8>) {
        if self.is_of_program(path) {
            self.take_file(path, bytes);
            return;
        }
        let Some(mut settings) = self.model.opened.as_ref().map(|opened| opened.settings.clone()) else {
            return self.fail(format!("{path}: open a scene first, then the kernel"));
        };
        // The name that the command line gave it.
        let known = settings.replaced.iter().find(|own| own.file == path).map(|own| own.kernel.clone());
        let own = match Replacement::new(known, path.to_owned(), bytes) {
            Ok(own) => own,
            Err(why) => return self.refuse_kernel(format!("{path}: {why}")),
        };
        self.host.watch(path);
        if settings.replaced.iter().any(|before| **before == own) && self.state.display.kernel_error.is_none() {
            return;
        }
        settings.replaced.retain(|other| other.kernel != own.kernel);
        settings.replaced.push(Arc::new(own));
        self.scene.awaits_kernel = true;
        self.plan(settings);
    }

    /// A file of a user's program was written: the run is made again with it, at the same place.
    fn take_file(&mut self, path: &str, bytes: Vec<u8>) {
        let Some(opened) = &self.model.opened else { return };
        let Some(folder) = &opened.settings.folder else { return };
        let Some(name) = folder.path_of(path) else { return };
        if folder.file(name) == Some(&bytes) && self.state.display.kernel_error.is_none() {
            return;
        }
        let settings = opened.settings.clone();
        match folder.with(name, bytes) {
            Ok(folder) => {
                self.scene.awaits_kernel = true;
                self.plan(Settings { folder: Some(Arc::new(folder)), ..settings });
            }
            Err(why) => self.refuse_kernel(format!("{path}: {why}")),
        }
    }

    /// Runs our own kernels again.
    pub(super) fn use_built_in_kernels(&mut self) {
        let Some(opened) = &self.model.opened else { return };
        let settings = Settings { replaced: Vec::new(), ..opened.settings.clone() };
        self.state.display.kernel_error = None;
        self.model.ask(Request::Plan(Box::new(settings)));
    }

    /// Whether a file is a kernel: by its ending, or because it is one of those that are replaced.
    pub(super) fn is_kernel(&self, path: &str) -> bool {
        let replaced = self.model.opened.iter().flat_map(|opened| &opened.settings.replaced);
        self.is_of_program(path)
            || path.to_ascii_lowercase().ends_with(".wgsl")
            || replaced.into_iter().any(|own| own.file == path)
    }

    /// Whether a file is one of the user's program that runs.
    fn is_of_program(&self, path: &str) -> bool {
        let folder = self.model.opened.as_ref().and_then(|opened| opened.settings.folder.as_ref());
        folder.is_some_and(|folder| folder.path_of(path).is_some())
    }

    /// The last version of a kernel is not used: says why, until one is.
    pub(super) fn refuse_kernel(&mut self, why: String) {
        self.state.display.kernel_error = Some(why.clone());
        self.fail(why);
    }

    /// Watches the files of the kernels that a run was opened with.
    pub(super) fn watch_kernels(&mut self) {
        let Some(opened) = &self.model.opened else { return };
        let mut files: Vec<String> = opened.settings.replaced.iter().map(|own| own.file.clone()).collect();
        if let Some(folder) = &opened.settings.folder {
            files.extend(folder.files().map(|(path, _)| folder.named(path)));
        }
        files.iter().for_each(|file| self.host.watch(file));
    }

    /// Whether a kernel is a user's, or is to be one.
    pub(super) fn has_own_kernels(&self) -> bool {
        self.state.display.kernel_error.is_some()
            || self.model.opened.as_ref().is_some_and(|opened| !opened.settings.replaced.is_empty())
    }
}
