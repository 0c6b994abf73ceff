//! What the plan lists: kernels, their draws, streams, buffers, and what is omitted.

use egui::Ui;
use raystep_kernels::fragment::depth_of;
use raystep_kernels::options::mapping::Update;
use raystep_kernels::plan::{Because, Bytes, DrawnPlan};
use raystep_kernels::shader::Variant;
use raystep_kernels::{Plan, Stream};
use raystep_lab::text::counted;

use crate::ui::panels::table::{Head, Listed, ListedCell, Table, View};

/// The names of the lists.
pub(super) const NAMES: [&str; 5] = ["kernels", "draws", "streams", "buffers", "omitted"];

/// Their heads.
pub(super) const HEADS: [&[Head<'static>]; 5] = [
    &[
        Head::text("kernel", "its name; hovering shows the states that it takes"),
        Head::number("bindings", "streams and buffers bound; hovering shows which it reads and writes"),
        Head::prose("what it does", "summary of the kernel"),
    ],
    &[
        Head::text("kernel", "the kernel whose pass it is a part of"),
        Head::text(
            "part",
            "copy or swap: how streams are read that are also written; depth: a draw that turns states into depths; draw: of the kernel",
        ),
        Head::text("of", "the streams that are copied, swapped or written"),
        Head::prose("reads", "the streams that the draw reads; bytes copied; the depth that it tests for"),
    ],
    &[
        Head::text("stream", "its name"),
        Head::number("bytes", "memory; compared in bytes"),
        Head::text("layers", "one texture layer each"),
        Head::prose("unit", "unit of its values"),
    ],
    &[
        Head::text("buffer", "its name"),
        Head::number("bytes", "memory; compared in bytes"),
        Head::prose("element", "what an element of it is"),
    ],
    &[
        Head::text("what", "what the run omits"),
        Head::text("because of", "what makes it unnecessary: the scene, the options or the view"),
        Head::prose("why", "the reason"),
    ],
];

/// A list, shown whole.
#[derive(Default)]
pub(super) struct List {
    rows: Listed,
    table: Table,
}

impl List {
    pub(super) fn is_empty(&self) -> bool {
        self.rows.rows.is_empty()
    }

    pub(super) fn set(&mut self, rows: Listed) {
        self.rows = rows;
    }

    pub(super) fn show(&mut self, ui: &mut Ui, name: &str, heads: &[Head<'_>], version: u64) {
        let view = View { name, heads, rows: &self.rows, version, current: None };
        self.table.show_all(ui, &view);
    }
}

/// One filter for all lists.
pub(super) fn field(ui: &mut Ui, lists: &mut [List; 5]) {
    let [first, rest @ ..] = lists;
    first.table.field(ui, "the plan");
    rest.iter_mut().filter(|list| list.table.filter != first.table.filter).for_each(|list| {
        list.table.filter.clone_from(&first.table.filter);
    });
}

/// The rows of each list.
pub(super) fn of(plan: &Plan) -> [Listed; 5] {
    let rows = |rows: Vec<Vec<ListedCell>>| Listed { rows };
    let reasons = [Because::Scene, Because::Options, Because::View];
    let omitted = reasons.into_iter().flat_map(|because| plan.left_out.iter().filter(move |o| o.because == because));
    let omitted = omitted.map(|item| {
        let because = match item.because {
            Because::Scene => "the scene",
            Because::Options => "the options",
            Because::View => "the view",
        };
        vec![ListedCell::text(&*item.what), ListedCell::text(because), ListedCell::text(item.reason)]
    });
    let streams = plan.streams.iter().map(|stream| {
        let info = stream.what.info();
        let group = plan.sharing.of(&stream.what);
        let shared = if group.len() > 1 { format!(", in one texture with {}", names(group)) } else { String::new() };
        let layers = ListedCell::text(info.layer_names() + &shared);
        vec![ListedCell::text(info.name), bytes(stream.bytes), layers, ListedCell::text(info.unit)]
    });
    let buffers = plan.buffers.iter().map(|planned| {
        let element = plan.program.buffer(planned.what).map_or("owned by the executor", |info| info.element);
        vec![ListedCell::text(planned.what), bytes(planned.bytes), ListedCell::text(element)]
    });
    [
        rows(plan.variants.iter().map(|variant| kernel(plan, variant)).collect()),
        rows(plan.drawn.as_ref().map_or_else(Vec::new, |drawn| draws(plan, drawn))),
        rows(streams.collect()),
        rows(buffers.collect()),
        rows(omitted.collect()),
    ]
}

fn names(streams: &[Stream]) -> String {
    streams.iter().map(|stream| stream.name()).collect::<Vec<_>>().join(", ")
}

/// The parts of each kernel's passes that are drawn, in order.
fn draws(plan: &Plan, drawn: &DrawnPlan) -> Vec<Vec<ListedCell>> {
    let mut rows = Vec::new();
    for kernel in &drawn.kernels {
        let name = kernel.kernel.name();
        let mut add = |part: &str, of: String, reads: String| {
            rows.push(vec![
                ListedCell::text(name),
                ListedCell::text(part),
                ListedCell::text(of),
                ListedCell::text(reads),
            ]);
        };
        if !kernel.updates.is_empty() {
            let copied = drawn.copied_bytes(kernel.kernel, plan.size());
            let (part, bytes) = match drawn.how.update {
                Update::Copy => ("copy", Bytes(copied).to_string()),
                Update::Swap => ("swap", String::new()),
            };
            add(part, names(&kernel.updates), bytes);
        }
        if drawn.depths.is_some() {
            add("depth", "from state".into(), format!("drawn where it is {}", depth_of(kernel.kernel)));
        }
        for draw in &kernel.draws {
            add("draw", names(&draw.targets), names(&draw.reads().collect::<Vec<_>>()));
        }
    }
    rows
}

fn kernel(plan: &Plan, variant: &Variant) -> Vec<ListedCell> {
    let info = variant.kernel.info();
    let names = |wanted: &dyn Fn(bool, bool) -> bool| {
        let bound = variant.bindings.iter().filter(|b| wanted(b.reads, b.writes));
        bound.map(|b| b.name.as_str()).collect::<Vec<_>>().join(", ")
    };
    let states: Vec<_> = info.takes.iter().map(|&tag| plan.program.states.name(tag)).collect();
    let bound = format!(
        "{}\nreads: {}\nwrites: {}\nupdates in place: {}",
        counted(variant.bindings.len(), "binding"),
        names(&|reads, writes| reads && !writes),
        names(&|reads, writes| writes && !reads),
        names(&|reads, writes| reads && writes),
    );
    let count = variant.bindings.len();
    vec![
        ListedCell::text(info.name).about(format!("{}\nprocesses rays in {}", info.summary, states.join(", "))),
        ListedCell::number(count as f64, count.to_string()).about(bound),
        ListedCell::text(info.summary),
    ]
}

fn bytes(bytes: u64) -> ListedCell {
    ListedCell::number(bytes as f64, Bytes(bytes).to_string()).about(format!("{bytes} bytes"))
}
