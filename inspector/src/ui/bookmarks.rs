//! Bookmarks: places of the open scene, each with the ray that was selected there.

use serde::{Deserialize, Serialize};

use super::Inspector;
use super::shared::{Bookmark, Shared};

/// Most characters of a name.
pub(super) const LONGEST_NAME: usize = 60;
/// Most bookmarks that are read from saved settings.
const MOST_SAVED: usize = 1000;

/// Bookmarks as they are saved.
#[derive(Serialize, Deserialize)]
struct Kept {
    /// Of which scene.
    scene: Option<String>,
    bookmarks: Vec<Bookmark>,
}

impl Shared {
    /// The index of the bookmark at a place.
    #[must_use]
    pub fn bookmark_at(&self, place: usize) -> Option<usize> {
        self.bookmarks.binary_search_by_key(&place, |bookmark| bookmark.place).ok()
    }

    /// The next bookmark after a place, or the previous one before it.
    #[must_use]
    pub fn bookmark_from(&self, place: usize, is_forward: bool) -> Option<usize> {
        let before = self.bookmarks.partition_point(|bookmark| bookmark.place < place);
        let until = self.bookmarks.partition_point(|bookmark| bookmark.place <= place);
        if is_forward { Some(until).filter(|&next| next < self.bookmarks.len()) } else { before.checked_sub(1) }
    }

    /// Adds a bookmark at a place, or removes the one that is there. Returns whether there is one now.
    pub fn toggle_bookmark(&mut self, place: usize) -> bool {
        match self.bookmarks.binary_search_by_key(&place, |bookmark| bookmark.place) {
            Ok(there) => {
                self.bookmarks.remove(there);
                false
            }
            Err(between) => {
                let name = place.checked_sub(1).map_or_else(|| "start".into(), |pass| format!("pass {pass}"));
                self.bookmarks.insert(between, Bookmark { place, pixel: self.pixel, name });
                true
            }
        }
    }

    /// Goes to a bookmark, and selects its ray.
    pub fn visit_bookmark(&mut self, index: usize) {
        if let Some(bookmark) = self.bookmarks.get(index) {
            self.scrub.go(bookmark.place);
            self.select = bookmark.pixel.or(self.select);
        }
    }

    /// Renames a bookmark; one without a name keeps its old one.
    pub fn rename_bookmark(&mut self, index: usize, name: &str) {
        let name: String = name.trim().chars().filter(|c| !c.is_control()).take(LONGEST_NAME).collect();
        if let Some(bookmark) = self.bookmarks.get_mut(index).filter(|_| !name.is_empty()) {
            bookmark.name = name;
        }
    }
}

impl Inspector {
    /// Adds a bookmark here, or removes it.
    pub(super) fn toggle_bookmark(&mut self) {
        let is_there = self.shared.toggle_bookmark(self.model.place);
        self.tell(if is_there { "bookmark added: see the timeline" } else { "bookmark removed" });
    }

    /// Goes to the next bookmark, or the previous one.
    pub(super) fn visit_bookmark(&mut self, is_forward: bool) {
        if let Some(index) = self.shared.bookmark_from(self.model.place, is_forward) {
            self.shared.visit_bookmark(index);
        }
    }

    /// A run is ready: bookmarks of another scene are dropped, and rays that its image does not have.
    pub(super) fn keep_bookmarks(&mut self) {
        let scene = self.path.as_deref().map(|path| {
            let (scene, index) = self.host.scene_of(path);
            index.map_or_else(|| scene.clone(), |index| format!("{scene}#{index}"))
        });
        if self.shared.bookmarked != scene {
            (self.shared.bookmarked, self.shared.bookmarks) = (scene, Vec::new());
        }
        let Some(opened) = &self.model.opened else { return };
        let [width, height] = [opened.plan.width, opened.plan.height];
        for bookmark in &mut self.shared.bookmarks {
            bookmark.pixel = bookmark.pixel.filter(|&[x, y]| x < width && y < height);
        }
    }

    /// The bookmarks for saving.
    pub(super) fn bookmarks_to_save(&self) -> Option<String> {
        let (scene, bookmarks) = (self.shared.bookmarked.clone(), self.shared.bookmarks.clone());
        if bookmarks.is_empty() { None } else { serde_json::to_string(&Kept { scene, bookmarks }).ok() }
    }

    /// Saved bookmarks: they stay if their scene is opened next.
    pub(super) fn restore_bookmarks(&mut self, saved: Option<&str>) {
        let Some(Kept { scene, mut bookmarks }) = saved.and_then(|text| serde_json::from_str(text).ok()) else {
            return;
        };
        bookmarks.truncate(MOST_SAVED);
        bookmarks.sort_by_key(|bookmark| bookmark.place);
        bookmarks.dedup_by_key(|bookmark| bookmark.place);
        for bookmark in &mut bookmarks {
            bookmark.name = bookmark.name.chars().filter(|c| !c.is_control()).take(LONGEST_NAME).collect();
        }
        (self.shared.bookmarked, self.shared.bookmarks) = (scene, bookmarks);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bookmarks_are_in_order_one_at_a_place_and_found_from_anywhere() {
        let mut shared = Shared { pixel: Some([3, 4]), ..Shared::default() };
        assert_eq!((shared.bookmark_from(5, true), shared.bookmark_from(5, false)), (None, None));
        for place in [12, 0, 7] {
            assert!(shared.toggle_bookmark(place));
        }
        let names: Vec<_> = shared.bookmarks.iter().map(|b| (b.place, b.name.as_str(), b.pixel)).collect();
        let ray = Some([3, 4]);
        assert_eq!(names, [(0, "start", ray), (7, "pass 6", ray), (12, "pass 11", ray)]);
        let from = |place, is_forward| shared.bookmark_from(place, is_forward).map(|i| shared.bookmarks[i].place);
        assert_eq!([0, 6, 7, 12].map(|place| from(place, true)), [Some(7), Some(7), Some(12), None]);
        assert_eq!([0, 7, 8, 99].map(|place| from(place, false)), [None, Some(0), Some(7), Some(12)]);
        assert!(!shared.toggle_bookmark(7) && shared.bookmark_at(7).is_none() && shared.bookmark_at(12) == Some(1));
    }

    #[test]
    fn a_visit_goes_to_the_place_and_the_ray_and_a_name_is_one_line() {
        let mut shared = Shared { pixel: Some([3, 4]), ..Shared::default() };
        shared.toggle_bookmark(9);
        shared.pixel = Some([0, 0]);
        shared.visit_bookmark(0);
        assert_eq!((shared.scrub.wanted(), shared.select), (Some(9), Some([3, 4])));
        shared.visit_bookmark(1);
        for (name, wanted) in [("  a\nb ", "ab"), ("", "ab"), (" ", "ab"), (&"é".repeat(99), &"é".repeat(60))] {
            shared.rename_bookmark(0, name);
            assert_eq!(shared.bookmarks[0].name, wanted);
        }
    }
}
