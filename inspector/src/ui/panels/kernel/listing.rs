//! A source with line numbers and marks, and below a condition's line how it came out. Only visible rows are laid out.

mod highlight;

use std::collections::HashMap;
use std::ops::Range;

use egui::{Align2, Color32, FontId, Rect, Sense, TextStyle, vec2};
use raystep_kernels::interpret::LineWork;
use raystep_lab::text::counted;

use super::run::Heat;
use crate::branches::Branch;
use crate::draw::stream::Colors;
use crate::source::{Line, Mark};
use highlight::job;

/// A row of the listing.
enum Row {
    /// A line of the source, by its index.
    Line(usize),
    /// About the condition of a branch.
    Note(Note),
}

/// What to scroll to: rows change with the width.
#[derive(Clone, Copy)]
enum Goal {
    /// A line, by its index.
    Line(usize),
    /// A branch's condition; the first line that ran if there is none.
    Site(Option<usize>),
}

/// A line about the condition of a branch.
#[derive(Clone)]
struct Note {
    site: usize,
    indent: usize,
    text: String,
    is_taken: bool,
    differs: bool,
}

/// What was clicked.
pub(super) enum Clicked {
    /// The condition of a branch.
    Site(usize),
    /// The number of a line, by its index.
    Line(usize),
}

/// Lines of a source.
#[derive(Default)]
pub(super) struct Listing {
    lines: Vec<Line>,
    /// What was said of branches, by the lines' indices.
    notes: Vec<(usize, Note)>,
    rows: Vec<Row>,
    /// Characters that notes may take, and those of the longest row.
    fits: usize,
    longest: usize,
    /// What to scroll to.
    scroll_to: Option<Goal>,
    /// Lines that are marked, by their indices.
    marked: Option<Range<usize>>,
    /// How the conditions of lines came out for all rays, by the lines' indices.
    heat: HashMap<usize, Heat>,
    /// What lines took for all rays, by the lines' indices.
    work: HashMap<usize, LineWork>,
}

impl Listing {
    /// Replaces the lines, each with the branches that are decided there.
    pub(super) fn set(&mut self, lines: Vec<Line>, branches: &[Vec<&Branch>]) {
        self.notes.clear();
        for (at, line) in lines.iter().enumerate() {
            let indent = line.text.len() - line.text.trim_start().len();
            for branch in branches.get(at).into_iter().flatten() {
                self.notes.extend(branch.notes.iter().enumerate().map(|(i, note)| {
                    let text = format!("{} {}", if i == 0 { "▸" } else { " " }, note.text);
                    (at, Note { site: branch.site, indent, text, is_taken: branch.is_taken, differs: note.differs })
                }));
            }
        }
        self.lines = lines;
        self.lay_out();
    }

    /// Makes the rows: notes are wrapped, lines of the source are not.
    fn lay_out(&mut self) {
        self.rows.clear();
        let mut notes = self.notes.iter().peekable();
        for at in 0..self.lines.len() {
            self.rows.push(Row::Line(at));
            while let Some((_, note)) = notes.next_if(|(line, _)| *line == at) {
                // One that is far to the right begins farther left instead of being wrapped at every word.
                let indent = note.indent.min(self.fits / 4);
                let parts = wrapped(&note.text, self.fits.saturating_sub(indent));
                self.rows.extend(parts.into_iter().map(|text| Row::Note(Note { indent, text, ..note.clone() })));
            }
        }
        let length = |row: &Row| match row {
            Row::Line(at) => self.lines.get(*at).map_or(0, |line| line.text.chars().count()),
            Row::Note(note) => note.indent + note.text.chars().count(),
        };
        self.longest = self.rows.iter().map(length).max().unwrap_or(0);
    }

    /// Shows how conditions came out for all rays of the pass.
    pub(super) fn warm(&mut self, heat: HashMap<usize, Heat>) {
        self.heat = heat;
    }

    /// Shows what lines took for all rays of the pass.
    pub(super) fn charge(&mut self, work: HashMap<usize, LineWork>) {
        self.work = work;
    }

    /// Marks lines, and scrolls to them.
    pub(super) fn mark(&mut self, lines: Option<Range<usize>>) {
        self.scroll_to = lines.as_ref().map(|lines| Goal::Line(lines.start)).or(self.scroll_to);
        self.marked = lines;
    }

    /// Whether a branch's condition is in the listing.
    pub(super) fn has(&self, site: usize) -> bool {
        self.row_of(site).is_some()
    }

    fn row_of(&self, wanted: usize) -> Option<usize> {
        self.rows.iter().position(|row| matches!(row, Row::Note(note) if note.site == wanted))
    }

    /// Scrolls to a branch's condition; to the first line that ran if there is none.
    pub(super) fn scroll_to(&mut self, site: Option<usize>) {
        self.scroll_to = Some(Goal::Site(site));
    }

    /// The row of a goal, the first one if it has none.
    fn row(&self, goal: Goal) -> usize {
        let ran = |row: &Row| matches!(row, Row::Line(at) if self.lines.get(*at).is_some_and(|l| l.mark == Mark::Run));
        let row = match goal {
            Goal::Line(line) => self.rows.iter().position(|row| matches!(row, Row::Line(at) if *at == line)),
            Goal::Site(site) => site.and_then(|site| self.row_of(site)).or_else(|| self.rows.iter().position(ran)),
        };
        row.unwrap_or(0)
    }

    /// The whole source.
    pub(super) fn text(&self) -> String {
        self.lines.iter().flat_map(|line| [line.text.as_str(), "\n"]).collect()
    }

    /// Shows it; returns what was clicked.
    pub(super) fn show(&mut self, ui: &mut egui::Ui, selected: Option<usize>) -> Option<Clicked> {
        let font = TextStyle::Monospace.resolve(ui.style());
        let height = ui.text_style_height(&TextStyle::Monospace) + 2.0;
        let character = ui.fonts_mut(|fonts| fonts.glyph_width(&font, '0'));
        ui.spacing_mut().item_spacing.y = 0.0;
        let digits = self.lines.len().max(1).ilog10() as usize + 1;
        let margin = (digits as f32 + 1.0) * character + 10.0;
        let fits = ((ui.available_width() - margin - ui.spacing().scroll.bar_width) / character).max(20.0) as usize;
        if std::mem::replace(&mut self.fits, fits) != fits {
            self.lay_out();
            self.scroll_to = self.scroll_to.or(selected.map(|site| Goal::Site(Some(site))));
        }
        let mut area = egui::ScrollArea::both().auto_shrink(false);
        if let Some(goal) = self.scroll_to.take() {
            let row = self.row(goal);
            // The lines before the branch are visible as well.
            let is_marked = self.marked.is_some();
            let above = if is_marked { 2.0 * height } else { ui.available_height() * 0.3 };
            area = area.vertical_scroll_offset((row as f32 * height - above).max(0.0));
        }
        let width = margin + (self.longest as f32 + 1.0) * character;
        let is_marked = self.lines.iter().any(|line| line.mark == Mark::Run);
        let mut clicked = None;
        area.show_rows(ui, height, self.rows.len(), |ui, rows| {
            ui.set_min_width(width);
            for row in rows.filter_map(|row| self.rows.get(row)) {
                ui.horizontal(|ui| {
                    ui.set_height(height);
                    ui.spacing_mut().item_spacing.x = 0.0;
                    let (gutter, _) = ui.allocate_exact_size(vec2(margin, height), Sense::hover());
                    match row {
                        Row::Line(at) => {
                            let Some(line) = self.lines.get(*at) else { return };
                            if self.marked.as_ref().is_some_and(|marked| marked.contains(at)) {
                                let color = ui.visuals().selection.bg_fill.gamma_multiply(0.35);
                                ui.painter().rect_filled(gutter.with_max_x(ui.clip_rect().right()), 0.0, color);
                            }
                            let heat = self.heat.get(at);
                            if let Some(heat) = heat {
                                paint_heat(ui, gutter, heat);
                            }
                            paint_gutter(ui, gutter, at + 1, line.mark, &font);
                            // No widget of its own: readers of the screen would hear one for each line.
                            if ui.rect_contains_pointer(gutter) {
                                ui.ctx().set_cursor_icon(egui::CursorIcon::PointingHand);
                                if ui.input(|input| input.pointer.primary_clicked()) {
                                    clicked = Some(Clicked::Line(*at));
                                }
                            }
                            let job = job(line, &font, ui.visuals(), is_marked);
                            let response = ui.add(egui::Label::new(job).selectable(true).extend());
                            let cost = self.work.get(at).map(told);
                            let about: Vec<String> = meaning(line.mark).map(str::to_owned).into_iter().chain(cost).collect();
                            if !about.is_empty() {
                                response.on_hover_text(about.join("\n"));
                            }
                            if let Some(heat) = heat {
                                ui.add_space(character);
                                let text = format!("{} of {}: {} true", heat.reached, heat.of, heat.taken);
                                let about = "rays that reached this condition, of those that the pass worked on; for how \
                                             many it was true";
                                ui.add(egui::Label::new(egui::RichText::new(text).weak()).extend()).on_hover_text(about);
                            }
                        }
                        Row::Note(Note { site, indent, text, is_taken, differs }) => {
                            ui.add_space(*indent as f32 * character);
                            let color = note_color(ui.visuals(), *is_taken, *differs);
                            let mut text = egui::RichText::new(text).font(font.clone()).color(color);
                            if selected == Some(*site) {
                                text = text.background_color(ui.visuals().selection.bg_fill.gamma_multiply(0.4));
                            }
                            let label = egui::Label::new(text).sense(Sense::click()).selectable(false).extend();
                            if ui.add(label).on_hover_text("click to look at this branch").clicked() {
                                clicked = Some(Clicked::Site(*site));
                            }
                        }
                    }
                });
            }
        });
        clicked
    }
}

/// Parts of a text of at most so many characters, split at spaces; those after the first are indented.
fn wrapped(text: &str, most: usize) -> Vec<String> {
    let mut parts = vec![String::new()];
    let begin = text.len() - text.trim_start_matches([' ', '▸']).len();
    for word in text[begin..].split(' ') {
        let last = parts.last_mut().map_or(0, |last| last.chars().count());
        if last > 4 && last + 1 + word.chars().count() > most {
            parts.push("   ".into());
        }
        if let Some(last) = parts.last_mut() {
            if last.is_empty() {
                last.push_str(&text[..begin]);
            } else {
                last.push(' ');
            }
            last.push_str(word);
        }
    }
    parts
}

/// Taken, not taken, and what f64 decides otherwise.
fn note_color(visuals: &egui::Visuals, is_taken: bool, differs: bool) -> Color32 {
    let [r, g, b] = match (differs, is_taken, visuals.dark_mode) {
        (true, _, true) => [240, 130, 220],
        (true, _, false) => [160, 20, 130],
        (_, true, true) => [240, 190, 90],
        (_, true, false) => [135, 80, 0],
        (_, false, _) => return visuals.weak_text_color(),
    };
    Color32::from_rgb(r, g, b)
}

/// What a line took, in words.
fn told(line: &LineWork) -> String {
    let (operations, bytes) = (line.work.operations(), line.work.bytes());
    let ratio = if bytes > 0 { format!(", {:.2} a byte", operations as f64 / bytes as f64) } else { String::new() };
    let runs = counted(line.runs, "time");
    format!(
        "all rays of this pass: ran {runs}, {}{ratio}, {} of streams and scene data",
        counted(operations, "operation"),
        counted(bytes, "byte"),
    )
}

/// Describes a mark.
fn meaning(mark: Mark) -> Option<&'static str> {
    match mark {
        Mark::Plain | Mark::Run => None,
        Mark::NotRun => Some("did not run for this ray in this pass"),
        Mark::LeftOut => Some("omitted in this plan"),
    }
}

/// Legend of the bars.
pub(super) fn legend(ui: &mut egui::Ui) {
    let (rect, _) = ui.allocate_exact_size(vec2(5.0, 12.0), Sense::hover());
    paint_bar(ui.painter(), rect, Mark::Run, ui.visuals());
    let label = ui.add(egui::Label::new(egui::RichText::new("ran").small()).extend());
    label.on_hover_text("ran for this ray in this pass; lines that did not run are dimmed");
}

/// A bar as long as the share of rays that reached the line.
fn paint_heat(ui: &egui::Ui, gutter: Rect, heat: &Heat) {
    let share = if heat.of == 0 { 0.0 } else { heat.reached as f32 / heat.of as f32 };
    let [r, g, b] = Colors::Viridis.at(f64::from(share));
    let bar = gutter.with_max_x(gutter.left() + share * (gutter.width() - 9.0));
    ui.painter().rect_filled(bar.shrink2(vec2(0.0, 1.0)), 0.0, Color32::from_rgb(r, g, b).gamma_multiply(0.35));
}

fn paint_gutter(ui: &egui::Ui, rect: Rect, number: usize, mark: Mark, font: &FontId) {
    let right = rect.right_center() - vec2(9.0, 0.0);
    let color = ui.visuals().weak_text_color();
    let color = if mark == Mark::Run { ui.visuals().text_color() } else { color };
    ui.painter().text(right, Align2::RIGHT_CENTER, number, font.clone(), color);
    let bar = Rect::from_min_max(rect.right_top() - vec2(6.0, 0.0), rect.right_bottom() - vec2(3.0, 0.0));
    paint_bar(ui.painter(), bar, mark, ui.visuals());
}

fn paint_bar(painter: &egui::Painter, rect: Rect, mark: Mark, visuals: &egui::Visuals) {
    let [r, g, b] = if visuals.dark_mode { [80, 200, 120] } else { [20, 140, 65] };
    if mark == Mark::Run {
        painter.rect_filled(rect, 0.0, Color32::from_rgb(r, g, b));
    }
}

#[cfg(test)]
mod tests {
    use egui::text::LayoutJob;

    use super::*;
    use crate::source;

    #[test]
    fn notes_are_wrapped_at_spaces_and_keep_every_word() {
        let text = "▸ false: nearest_t 0.81207854 <= exit 0.77371347 is false";
        assert_eq!(wrapped(text, 100), [text]);
        let parts = wrapped(text, 30);
        assert_eq!(parts, ["▸ false: nearest_t 0.81207854", "    <= exit 0.77371347 is", "    false"]);
        assert_eq!(wrapped("   in f64: 1", 9), ["   in", "    f64:", "    1"]);
        assert_eq!(wrapped("averylongword", 4), ["averylongword"]);
    }

    #[test]
    fn the_whole_line_is_laid_out_and_what_is_left_out_is_struck() {
        let mut lines = source::lines("  let a = f(1u); // one\n@if(grid) x();\n");
        lines[1].mark = Mark::LeftOut;
        let visuals = egui::Visuals::dark();
        let jobs = lines.iter().map(|line| job(line, &FontId::monospace(12.0), &visuals, true)).collect::<Vec<_>>();
        for (line, job) in lines.iter().zip(&jobs) {
            assert_eq!(job.text, line.text);
        }
        let struck =
            |job: &LayoutJob| job.sections.iter().any(|s| s.format.strikethrough.color != Color32::TRANSPARENT);
        assert!(struck(&jobs[1]) && !struck(&jobs[0]));
        let mut listing = Listing::default();
        listing.set(lines, &[]);
        assert_eq!(listing.text(), "  let a = f(1u); // one\n@if(grid) x();\n");
    }
}
