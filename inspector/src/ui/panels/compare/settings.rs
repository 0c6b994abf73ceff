//! The settings of the two runs that are compared: what distinguishes them, and those of the other one to edit.

use egui::{ComboBox, Ui};
use raystep_kernels::options::mapping::MappingName;
use raystep_kernels::options::rows::Row;

use crate::settings::{DeviceKind, Settings};
use crate::ui::choice::Choices as _;

/// The settings that distinguish a run.
pub(super) fn text_of(settings: &Settings) -> String {
    let (order, rules) = (settings.order(), settings.rules());
    format!("{}, {order}, {rules}, {}", settings.choices.accelerator, settings.device.name())
}

/// Where passes run, and how: fragment programs run on a GPU only.
#[derive(Clone, Copy, PartialEq)]
struct RunsOn {
    device: DeviceKind,
    mapping: MappingName,
}

impl RunsOn {
    const ALL: [Self; 4] = [
        Self { device: DeviceKind::Gpu, mapping: MappingName::Compute },
        Self { device: DeviceKind::Gpu, mapping: MappingName::Fragment },
        Self { device: DeviceKind::Cpu, mapping: MappingName::Compute },
        Self { device: DeviceKind::CpuF64, mapping: MappingName::Compute },
    ];

    fn name(self) -> &'static str {
        match self.mapping {
            MappingName::Compute => self.device.name(),
            MappingName::Fragment => "GPU, fragment",
        }
    }
}

/// The settings of the other run, if they were changed.
pub(super) fn edit(ui: &mut Ui, settings: &Settings) -> Option<Settings> {
    let mut new = settings.clone();
    for row in ["accelerator", "schedule", "numerics"].into_iter().filter_map(Row::named) {
        let mut value = row.get(&new.choices).to_string();
        let offered: Vec<String> = new.offered(row).into_iter().map(String::from).collect();
        if combo(ui, row.name, &offered, String::clone, &mut value) {
            // What is offered can be chosen.
            _ = new.choose(row, &value);
        }
    }
    let mut place = RunsOn { device: new.device, mapping: new.choices.mapping.name() };
    combo(ui, "device", &RunsOn::ALL, |runs_on| runs_on.name().into(), &mut place);
    if let Some(mapping) = Row::named("mapping").filter(|_| place.mapping != new.choices.mapping.name()) {
        _ = new.choose(mapping, place.mapping.name());
    }
    new.device = place.device;
    (new != *settings).then_some(new)
}

/// Whether another value was chosen.
fn combo<T: Clone + PartialEq>(ui: &mut Ui, name: &str, all: &[T], text: fn(&T) -> String, value: &mut T) -> bool {
    let before = value.clone();
    let shown = ComboBox::from_id_salt(("compare", name)).selected_text(text(value)).width(70.0);
    let response = shown.show_ui(ui, |ui| {
        for one in all {
            ui.choice_of(value, one.clone(), text(one));
        }
    });
    response.response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::ComboBox, true, format!("B's {name}")));
    *value != before
}
