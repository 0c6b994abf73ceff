//! What the plan lists: kernels, streams, buffers, and what is omitted.

use egui::Ui;
use raystep_kernels::Plan;
use raystep_kernels::plan::{Because, Bytes};
use raystep_kernels::shader::Variant;
use raystep_lab::text::counted;

use crate::ui::panels::table::{Head, Listed, ListedCell, Table, View};

/// The names of the lists.
pub(super) const NAMES: [&str; 4] = ["kernels", "streams", "buffers", "omitted"];

/// Their heads.
pub(super) const HEADS: [&[Head<'static>]; 4] = [
    &[
        Head::text("kernel", "its name; hovering shows the states that it takes"),
        Head::number("bindings", "streams and buffers bound; hovering shows which it reads and writes"),
        Head::prose("what it does", "summary of the kernel"),
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
    pub(super) fn set(&mut self, rows: Listed) {
        self.rows = rows;
    }

    pub(super) fn show(&mut self, ui: &mut Ui, name: &str, heads: &[Head<'_>], version: u64) {
        let view = View { name, heads, rows: &self.rows, version, current: None };
        self.table.show_all(ui, &view);
    }
}

/// One filter for all lists.
pub(super) fn field(ui: &mut Ui, lists: &mut [List; 4]) {
    let [first, rest @ ..] = lists;
    first.table.field(ui, "the plan");
    rest.iter_mut().filter(|list| list.table.filter != first.table.filter).for_each(|list| {
        list.table.filter.clone_from(&first.table.filter);
    });
}

/// The rows of each list.
pub(super) fn of(plan: &Plan) -> [Listed; 4] {
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
        let layers = ListedCell::text(info.layers.join(" "));
        vec![ListedCell::text(info.name), bytes(stream.bytes), layers, ListedCell::text(info.unit)]
    });
    let buffers = plan.buffers.iter().map(|planned| {
        let element = plan.program.buffer(planned.what).map_or("owned by the executor", |info| info.element);
        vec![ListedCell::text(planned.what), bytes(planned.bytes), ListedCell::text(element)]
    });
    [
        rows(plan.variants.iter().map(|variant| kernel(plan, variant)).collect()),
        rows(streams.collect()),
        rows(buffers.collect()),
        rows(omitted.collect()),
    ]
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
