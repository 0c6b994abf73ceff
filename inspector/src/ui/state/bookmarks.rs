//! Bookmarks: places of the open scene, each with the ray that was selected there.

use serde::{Deserialize, Serialize};

use super::Asks;
use crate::session_file::Bookmark;

/// Most characters of a name.
const LONGEST_NAME: usize = 60;
/// Most bookmarks that are read from saved settings.
const MOST_SAVED: usize = 1000;

/// The bookmarks of a scene. Also as they are saved.
#[derive(Clone, Default, Serialize, Deserialize)]
pub struct Bookmarks {
    /// The scene that they belong to.
    pub scene: Option<String>,
    /// By the number of passes.
    #[serde(rename = "bookmarks")]
    pub list: Vec<Bookmark>,
}

impl Bookmarks {
    /// The index of the bookmark at a place.
    #[must_use]
    pub fn at(&self, place: usize) -> Option<usize> {
        self.list.binary_search_by_key(&place, |bookmark| bookmark.place).ok()
    }

    /// The next bookmark after a place, or the previous one before it.
    #[must_use]
    pub fn from(&self, place: usize, is_forward: bool) -> Option<usize> {
        let before = self.list.partition_point(|bookmark| bookmark.place < place);
        let until = self.list.partition_point(|bookmark| bookmark.place <= place);
        if is_forward { Some(until).filter(|&next| next < self.list.len()) } else { before.checked_sub(1) }
    }

    /// Adds a bookmark at a place with the selected ray, or removes the one that is there. Returns whether there is one
    /// now.
    pub fn toggle(&mut self, place: usize, pixel: Option<[u32; 2]>) -> bool {
        match self.list.binary_search_by_key(&place, |bookmark| bookmark.place) {
            Ok(there) => {
                self.list.remove(there);
                false
            }
            Err(between) => {
                let name = place.checked_sub(1).map_or_else(|| "start".into(), |pass| format!("pass {pass}"));
                self.list.insert(between, Bookmark { place, pixel, name });
                true
            }
        }
    }

    /// Goes to a bookmark, and selects its ray.
    pub fn visit(&self, index: usize, asks: &mut Asks) {
        if let Some(bookmark) = self.list.get(index) {
            asks.scrub.go(bookmark.place);
            asks.select = bookmark.pixel.or(asks.select);
        }
    }

    /// Renames a bookmark; one without a name keeps its old one.
    pub fn rename(&mut self, index: usize, name: &str) {
        let name = plain(name.trim());
        if let Some(bookmark) = self.list.get_mut(index).filter(|_| !name.is_empty()) {
            bookmark.name = name;
        }
    }

    /// A run is ready: bookmarks of another scene are dropped, and rays that its image does not have.
    pub fn keep(&mut self, scene: Option<String>, [width, height]: [u32; 2]) {
        if self.scene != scene {
            *self = Self { scene, list: Vec::new() };
        }
        for bookmark in &mut self.list {
            bookmark.pixel = bookmark.pixel.filter(|&[x, y]| x < width && y < height);
        }
    }

    /// As text for saving; `None` without any.
    #[must_use]
    pub fn to_save(&self) -> Option<String> {
        if self.list.is_empty() { None } else { serde_json::to_string(self).ok() }
    }

    /// Saved bookmarks, as far as they can be read: they stay if their scene is opened next.
    #[must_use]
    pub fn read(saved: &str) -> Option<Self> {
        let mut read: Self = serde_json::from_str(saved).ok()?;
        read.list.truncate(MOST_SAVED);
        read.list.sort_by_key(|bookmark| bookmark.place);
        read.list.dedup_by_key(|bookmark| bookmark.place);
        for bookmark in &mut read.list {
            bookmark.name = plain(&bookmark.name);
        }
        Some(read)
    }
}

/// A name in one line that is not too long.
fn plain(name: &str) -> String {
    name.chars().filter(|c| !c.is_control()).take(LONGEST_NAME).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bookmarks_are_in_order_one_at_a_place_and_found_from_anywhere() {
        let mut bookmarks = Bookmarks::default();
        let ray = Some([3, 4]);
        assert_eq!((bookmarks.from(5, true), bookmarks.from(5, false)), (None, None));
        for place in [12, 0, 7] {
            assert!(bookmarks.toggle(place, ray));
        }
        let names: Vec<_> = bookmarks.list.iter().map(|b| (b.place, b.name.as_str(), b.pixel)).collect();
        assert_eq!(names, [(0, "start", ray), (7, "pass 6", ray), (12, "pass 11", ray)]);
        let from = |place, is_forward| bookmarks.from(place, is_forward).map(|i| bookmarks.list[i].place);
        assert_eq!([0, 6, 7, 12].map(|place| from(place, true)), [Some(7), Some(7), Some(12), None]);
        assert_eq!([0, 7, 8, 99].map(|place| from(place, false)), [None, Some(0), Some(7), Some(12)]);
        assert!(!bookmarks.toggle(7, ray) && bookmarks.at(7).is_none() && bookmarks.at(12) == Some(1));
    }

    #[test]
    fn a_visit_goes_to_the_place_and_the_ray_and_a_name_is_one_line() {
        let (mut bookmarks, mut asks) = (Bookmarks::default(), Asks::default());
        bookmarks.toggle(9, Some([3, 4]));
        bookmarks.visit(0, &mut asks);
        assert_eq!((asks.scrub.wanted(), asks.select), (Some(9), Some([3, 4])));
        bookmarks.visit(1, &mut asks);
        for (name, wanted) in [("  a\nb ", "ab"), ("", "ab"), (" ", "ab"), (&"é".repeat(99), &"é".repeat(60))] {
            bookmarks.rename(0, name);
            assert_eq!(bookmarks.list[0].name, wanted);
        }
    }
}
