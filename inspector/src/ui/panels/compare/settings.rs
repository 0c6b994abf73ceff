//! The settings of the two runs that are compared: what distinguishes them, and those of the other one to edit.

use egui::{ComboBox, Ui};
use raystep_kernels::options::mapping::MappingName;
use raystep_kernels::{Accelerator, Numerics, ScheduleKind};

use crate::settings::{DeviceKind, Settings};

/// The settings that distinguish a run.
pub(super) fn text_of(settings: &Settings) -> String {
    let Settings { accelerator, device, .. } = settings;
    let (order, rules) = (settings.order(), settings.rules());
    format!("{accelerator}, {order}, {rules}, {}", device.name())
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
    fn combo<T: Copy + PartialEq>(ui: &mut Ui, name: &str, all: &[T], text: fn(T) -> &'static str, value: &mut T) {
        let shown = ComboBox::from_id_salt(("compare", name)).selected_text(text(*value)).width(70.0);
        let response = shown.show_ui(ui, |ui| {
            for &one in all {
                ui.selectable_value(value, one, text(one));
            }
        });
        response.response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::ComboBox, true, format!("B's {name}")));
    }
    let stepped = new.schedules();
    combo(ui, "accelerator", Accelerator::ALL, Accelerator::name, &mut new.accelerator);
    combo(ui, "schedule", &stepped, ScheduleKind::name, &mut new.schedule);
    combo(ui, "numerics", Numerics::ALL, Numerics::name, &mut new.numerics);
    let mut place = RunsOn { device: new.device, mapping: new.mapping.name() };
    combo(ui, "device", &RunsOn::ALL, RunsOn::name, &mut place);
    if place.mapping != new.mapping.name() {
        new.map_kernels(place.mapping);
    }
    new.device = place.device;
    (new != *settings).then_some(new)
}
