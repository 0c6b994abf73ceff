//! Which layout is shown, those that the user saved, and how the others were left.

use egui_tiles::Tree;

use super::{Desk, layout};
use crate::command::{Command, Layout, MOST_OWN};
use crate::saved::OwnLayout;
use crate::ui::panes::Pane;

/// Longest name of a layout, in characters.
pub(in crate::ui) const LONGEST_NAME: usize = 20;

/// The layouts besides the arrangement that is shown.
#[derive(Default)]
pub(in crate::ui) struct Arranged {
    /// Which one is shown.
    pub(in crate::ui) now: Now,
    /// Those that the user saved.
    pub(in crate::ui) own: Vec<OwnLayout>,
    /// How others were left, until the window closes.
    left: Vec<(Now, Tree<Pane>)>,
}

/// A layout that can be shown.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(in crate::ui) enum Now {
    /// One that is built in.
    Task(Layout),
    /// One of the user's, by its name.
    Own(String),
}

impl Default for Now {
    fn default() -> Self {
        Self::Task(Layout::default())
    }
}

impl Now {
    /// Its name.
    pub(in crate::ui) fn name(&self) -> &str {
        match self {
            Self::Task(layout) => layout.name(),
            Self::Own(name) => name,
        }
    }
}

impl Arranged {
    /// Takes those that were saved, as far as they can be shown.
    pub(in crate::ui) fn restore(&mut self, saved: &[OwnLayout]) {
        let sound = saved.iter().filter(|own| crate::session_file::layout::is_sound(&own.tree));
        self.own = sound.take(MOST_OWN).cloned().collect();
    }

    /// The layout that a command shows.
    pub(in crate::ui) fn of(&self, command: Command) -> Option<Now> {
        match command {
            Command::Arrange(layout) => Some(Now::Task(layout)),
            Command::ArrangeOwn(index) => self.own.get(index).map(|own| Now::Own(own.name.clone())),
            _ => None,
        }
    }

    /// The layout with this name; the first one if there is none.
    pub(in crate::ui) fn named(&self, name: &str) -> Now {
        let task = Layout::ALL.into_iter().find(|layout| layout.name() == name).map(Now::Task);
        let own = || self.own.iter().find(|own| own.name == name).map(|own| Now::Own(own.name.clone()));
        task.or_else(own).unwrap_or_default()
    }

    /// As it was saved or built.
    fn fresh(&self, now: &Now) -> Tree<Pane> {
        match now {
            Now::Task(layout) => layout::tree(*layout),
            Now::Own(name) => {
                let own = self.own.iter().find(|own| own.name == *name);
                let tree = own.and_then(|own| crate::session_file::layout::read(&own.tree).ok());
                tree.unwrap_or_else(|| layout::tree(Layout::default()))
            }
        }
    }

    /// Why a name cannot be given to one more layout.
    pub(in crate::ui) fn refusal(&self, name: &str) -> Option<String> {
        let is_new = self.own.iter().all(|own| own.name != name);
        if name.is_empty() || name.chars().count() > LONGEST_NAME {
            Some(format!("expected a name of 1 to {LONGEST_NAME} characters"))
        } else if Layout::ALL.iter().any(|layout| layout.name().eq_ignore_ascii_case(name)) {
            Some(format!("{name} is built in: choose another name"))
        } else if is_new && self.own.len() == MOST_OWN {
            Some(format!("there are {MOST_OWN} already: give the name of one, which is replaced, or delete one"))
        } else {
            None
        }
    }
}

impl Desk {
    /// Shows a layout as it was left, or as it is at first.
    pub(in crate::ui) fn arrange(&mut self, to: Now) {
        self.maximised = None;
        if to == self.arranged.now {
            return;
        }
        let left = &mut self.arranged.left;
        let known = left.iter().position(|(now, _)| *now == to).map(|at| left.swap_remove(at).1);
        let tree = known.unwrap_or_else(|| self.arranged.fresh(&to));
        let old = (std::mem::replace(&mut self.arranged.now, to), std::mem::replace(&mut self.tree, tree));
        self.arranged.left.push(old);
    }

    /// What is shown goes to somebody who brings it back; the panels of lessons are in its place.
    pub(in crate::ui) fn lend(&mut self) -> (Tree<Pane>, Now) {
        let tree = std::mem::replace(&mut self.tree, layout::tree(Layout::Learn));
        (tree, std::mem::replace(&mut self.arranged.now, Now::Task(Layout::Learn)))
    }

    /// Brings back what was lent, and forgets the panels of the lesson.
    pub(in crate::ui) fn return_to(&mut self, tree: Tree<Pane>, now: Now) {
        self.arranged.left.retain(|(left, _)| *left != Now::Task(Layout::Learn) && *left != now);
        (self.tree, self.arranged.now) = (tree, now);
    }

    /// Shows the layout as it is at first.
    pub(in crate::ui) fn reset_layout(&mut self) {
        self.maximised = None;
        self.tree = self.arranged.fresh(&self.arranged.now);
    }

    /// Saves the arrangement under a name, in place of an older one with that name, and shows it as that layout.
    pub(in crate::ui) fn save_layout(&mut self, name: &str) -> Result<(), String> {
        let name = name.trim();
        if let Some(refusal) = self.arranged.refusal(name) {
            return Err(refusal);
        }
        let tree = serde_json::to_string(&self.tree).map_err(|error| error.to_string())?;
        match self.arranged.own.iter_mut().find(|own| own.name == name) {
            // Its key stays.
            Some(own) => own.tree = tree,
            None => self.arranged.own.push(OwnLayout { name: name.to_owned(), tree }),
        }
        self.arranged.now = Now::Own(name.to_owned());
        // How an older one of that name was left no longer counts.
        self.arranged.left.retain(|(left, _)| *left != self.arranged.now);
        Ok(())
    }

    /// Removes one of the user's layouts; if it is shown, the first built-in one takes its place.
    pub(in crate::ui) fn delete_layout(&mut self, index: usize) {
        let Some(gone) = self.arranged.of(Command::ArrangeOwn(index)) else { return };
        if self.arranged.now == gone {
            self.arrange(Now::default());
        }
        self.arranged.own.remove(index);
        self.arranged.left.retain(|(left, _)| *left != gone);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn own_layouts_that_cannot_be_shown_are_left_out() {
        let real = serde_json::to_string(&layout::tree(Layout::Step)).expect("a tree");
        let own = |name: &str, tree: &str| OwnLayout { name: name.into(), tree: tree.into() };
        let mut saved = vec![own("broken", "{}"), own("first", &real)];
        saved.extend((0..9).map(|i| own(&i.to_string(), &real)));
        let mut arranged = Arranged::default();
        arranged.restore(&saved);
        let names: Vec<_> = arranged.own.iter().map(|own| own.name.as_str()).collect();
        assert_eq!(names, ["first", "0", "1", "2"]);
        assert_eq!((arranged.named("1"), arranged.named("Ray")), (Now::Own("1".into()), Now::Task(Layout::Ray)));
        // The ones that are left keep their names, and no longer all keys are taken.
        assert!(arranged.refusal("new").is_some() && arranged.refusal("1").is_none());
        let mut desk = Desk { arranged, ..Desk::default() };
        desk.arrange(Now::Own("0".into()));
        desk.delete_layout(1);
        let arranged = &desk.arranged;
        assert_eq!((arranged.named("0"), arranged.refusal("new")), (Now::default(), None));
        assert_eq!((&arranged.now, arranged.left.len()), (&Now::default(), 0));
    }
}
