//! The dialog that exports: what, and how much of it.

use egui::{Button, Ui};
use raystep_lab::text::counted;

use super::Inspector;
use crate::command::Command;
use crate::ui::style::strong;

impl Inspector {
    /// Shows the exports with what each would hold; returns the one that was chosen.
    pub(super) fn choose_export(&self, ui: &mut Ui, is_up_to_here: &mut bool) -> Option<Command> {
        use Command as C;
        ui.heading("Export");
        let (place, known) = (self.model.place, self.model.passes.len());
        let all = match self.model.is_complete {
            true => format!("the whole run: {}", counted(known, "pass")),
            false => "the whole run; its remaining passes run first".into(),
        };
        ui.radio_value(is_up_to_here, false, all);
        ui.radio_value(is_up_to_here, true, format!("up to here: {}", counted(place, "pass")));
        let mut chosen = None;
        let mut group = |ui: &mut Ui, what: String, commands: &[Command]| {
            ui.separator();
            strong(ui, what);
            for &command in commands {
                if ui.add_enabled(self.can(command), Button::new(command.name())).clicked() {
                    chosen = Some(command);
                }
            }
        };
        let rows = match (*is_up_to_here, self.model.is_complete) {
            (true, _) => counted(place.min(known), "row"),
            (false, true) => counted(known, "row"),
            (false, false) => "a row per pass".into(),
        };
        group(ui, format!("Passes: {rows}"), &[C::ExportPasses, C::ExportTrace]);
        if self.model.has_rays() {
            group(ui, self.which_ray(*is_up_to_here), &[C::ExportRay, C::ExportWalk]);
        }
        let stream = self.state.display.stream.map_or_else(|| "Stream".into(), |stream| self.which_stream(stream));
        group(ui, stream, &[C::ExportExr, C::ExportNpy, C::ExportTexels, C::ExportView]);
        group(ui, "Data flow of the program".into(), &[C::ExportDataflow]);
        chosen
    }

    fn which_ray(&self, is_up_to_here: bool) -> String {
        let Some(history) = &self.model.history else { return "Ray: none is selected".into() };
        let place = self.model.place;
        let rows = history.rows.iter().filter(|row| !is_up_to_here || row.is_within(place)).count();
        format!("Ray of {}: {}", history.name(), counted(rows, "row"))
    }

    fn which_stream(&self, stream: raystep_kernels::Stream) -> String {
        let size = self.model.texture(stream).map(|texture| (texture.width(), texture.height()));
        let size = size.map_or_else(String::new, |(width, height)| format!(" of {width} × {height} texels"));
        let layers = counted(stream.layers(), "layer");
        format!("Stream {} after {}: {layers}{size}", stream.name(), counted(self.model.place, "pass"))
    }
}
