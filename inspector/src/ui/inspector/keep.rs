//! Settings that persist between sessions: the layout, watches, bookmarks, the last place, recent files.

use crate::ui::state::Bookmarks;
use egui_tiles::Tree;

use super::Inspector;
use crate::saved::Saved;
use crate::session::Watch;
use crate::ui::panes::Pane;

impl Inspector {
    /// Restores saved settings. What cannot be read is reported, and keeps its default.
    pub fn restore(&mut self, bytes: &[u8]) {
        let (saved, error) = Saved::from_bytes_or_default(bytes);
        if let Some(error) = error {
            self.fail(error.to_string());
        }
        if let Some(tree) = saved.layout.as_deref().and_then(|text| serde_json::from_str::<Tree<Pane>>(text).ok()) {
            *self.own_tree_mut() = tree;
        }
        self.desk.arranged.restore(&saved.layouts);
        *self.own_arranged_mut() = self.desk.arranged.named(&saved.layout_name);
        if let Some(watches) =
            saved.watches.as_deref().and_then(|text| serde_json::from_str::<Vec<(Watch, bool)>>(text).ok())
        {
            self.state.watches.list = watches;
        }
        if let Some(bookmarks) = saved.bookmarks.as_deref().and_then(Bookmarks::read) {
            self.state.bookmarks = bookmarks;
        }
        *self.own_units_mut() = saved.units;
        self.state.display.recent = saved.recent().to_vec();
        self.state.display.last_place = saved.link.as_ref().map(ToString::to_string);
        self.saved = saved;
        // The text size is set together with the style.
        self.is_styled = false;
    }

    /// Hands the settings to the host for saving.
    pub fn keep(&mut self) {
        (self.saved.layouts, self.saved.layout_name) =
            (self.desk.arranged.own.clone(), self.own_arranged().name().to_owned());
        self.saved.layout = serde_json::to_string(self.own_tree()).ok();
        self.saved.watches = serde_json::to_string(&self.state.watches.list).ok();
        self.saved.bookmarks = self.state.bookmarks.to_save();
        self.saved.units = self.own_units();
        if let Some(link) = self.link() {
            self.saved.link = Some(link);
        }
        match self.saved.to_text() {
            Ok(text) => self.host.remember(&text),
            Err(error) => self.fail(error.to_string()),
        }
    }

    /// A session was read from a file.
    pub(super) fn remember_session(&mut self, path: &str) {
        self.saved.opened(path);
        self.state.display.recent = self.saved.recent().to_vec();
    }

    /// A scene was read from a file.
    pub(super) fn remember_file(&mut self) {
        if let Some(path) = self.scene.path.as_deref().filter(|path| !path.starts_with(crate::lesson::built_in::PREFIX))
        {
            self.saved.opened(path);
            self.state.display.recent = self.saved.recent().to_vec();
        }
    }
}
