//! Which elements a pass works on, and to which states it sends them: the WGSL that every kernel of elements with states
//! shares (`live.wgsl`), and what is made of a program's rows for it.

use std::borrow::Cow;
use std::fmt::Write as _;

use super::{Kernel, Module, Program};
use crate::options::features::Features;
use crate::shared::constants;
use crate::tables::state::Tag;

/// The buffer with the elements of all lists.
pub const LIVE_RAYS: &str = "live_rays";

/// Bytes of that buffer, if each set with lists has so many texels: for each list, its elements now, and those of its
/// kernel's next pass.
#[must_use]
pub fn live_bytes(program: &Program, texels: u64) -> u64 {
    2 * 4 * texels * program.lists.len() as u64
}

/// A list of live elements that a run uses.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct LiveList {
    /// Its name.
    pub name: &'static str,
    /// The states whose elements wait in it.
    pub tags: Vec<Tag>,
}

/// The lists of a run with these kernels: those that one of them takes its elements from.
#[must_use]
pub fn lists(kernels: &[Kernel], features: &Features) -> Vec<LiveList> {
    let Some(program) = kernels.first().map(|kernel| kernel.program()).filter(|_| features.live_lists) else {
        return Vec::new();
    };
    let taker = |list: usize| kernels.iter().find(|kernel| kernel.list() == Some(list));
    let lists = program.lists.iter().enumerate();
    lists.filter_map(|(index, list)| Some(LiveList { name: list.name, tags: taker(index)?.takes().to_vec() })).collect()
}

/// Of a run's lists, those that a kernel may send elements to, and its own: it binds no others.
#[must_use]
pub fn lists_of(kernel: Kernel, lists: &[LiveList]) -> Vec<LiveList> {
    let own = kernel.list().map(|index| kernel.program().lists[index].name);
    let is_sent_to = |list: &&LiveList| kernel.sends().iter().any(|sent| list.tags.contains(&sent.to));
    lists.iter().filter(|list| Some(list.name) == own || is_sent_to(list)).cloned().collect()
}

/// The modules that any kernel may import, whatever its program: `constants`, `state` with the tags of the kernel's states
/// under its own names, `live`, and `lists`.
pub(crate) fn modules(kernel: Kernel, features: &Features, lists: &[LiveList]) -> [Module; 4] {
    let live = if features.fragments { include_str!("live_fragment.wgsl") } else { include_str!("live.wgsl") };
    [
        ("constants", Cow::Owned(constants::wgsl_module(features.stack, features.turns, features.depth))),
        ("state", Cow::Owned(state(kernel))),
        ("live", Cow::Borrowed(live)),
        ("lists", Cow::Owned(list_module(lists))),
    ]
}

/// The tags by their names in the program, or in the kernel if an instance renames its states.
fn state(kernel: Kernel) -> String {
    let states = kernel.program().states;
    let Some(renamed) = kernel.instance().renamed else { return states.wgsl_module() };
    let own = kernel.info().home.states;
    let tags = renamed.tags.iter().map(|&(tag, here)| format!("const {}: u32 = {here}u;\n", own.name(tag)));
    tags.chain([format!("const STATES: u32 = {}u;\n", states.0.len())]).collect()
}

/// A list's slot holds its indirect arguments (x groups, y groups, z), its number of elements, and its start.
fn list_module(lists: &[LiveList]) -> String {
    let mut text = String::from("import package::constants::{LIST_SIDE, LIST_GROUPS};\n\n");
    for (index, list) in (3..).zip(lists) {
        let name = list.name;
        _ = writeln!(text, "@group(2) @binding({index}) var<storage, read_write> {name}: array<atomic<u32>, 8>;");
    }
    _ = write!(
        text,
        "\nconst LISTS: u32 = {}u;\nconst IN_A_ROW: u32 = LIST_SIDE * LIST_SIDE * LIST_GROUPS;\n\n\
         // The list that elements in a state wait in.\nfn waiting_list(tag: u32) -> u32 {{\n",
        lists.len()
    );
    for (index, list) in lists.iter().enumerate() {
        let is: Vec<String> = list.tags.iter().map(|tag| format!("tag == {tag}u")).collect();
        _ = writeln!(text, "    if ({}) {{\n        return {index}u;\n    }}", is.join(" || "));
    }
    text += "    return LISTS;\n}\n\nfn rows_of(elements: u32) -> u32 {\n    \
             return (elements + IN_A_ROW - 1u) / IN_A_ROW;\n}\n\n\
             // Makes room for so many elements at the end of a list: returns where they begin.\n\
             fn reserve(list: u32, elements: u32) -> u32 {\n";
    for (index, list) in lists.iter().enumerate() {
        let name = list.name;
        _ = write!(
            text,
            "    if (list == {index}u) {{\n        let first = atomicAdd(&{name}[3], elements);\n        \
             if (rows_of(first + elements) != rows_of(first)) {{\n            \
             atomicMax(&{name}[1], rows_of(first + elements));\n        }}\n        \
             return first + atomicLoad(&{name}[4]);\n    }}\n"
        );
    }
    text + "    return 0u;\n}\n"
}
