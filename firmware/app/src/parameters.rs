//! The parameters by name, and the record in which they are saved.

use crate::Model;
use crate::model::fnv;
use preslide::control::Axis;
use preslide_link::{MOST_PARAMETERS, Name, Parameter};

/// When a parameter can be set.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum When {
    /// At any time: the change is faded in.
    Always,
    /// It says what the machine is.
    Disabled,
}

/// A parameter: its name is its path in `axis.toml`.
pub(crate) struct Entry {
    pub(crate) name: &'static str,
    pub(crate) when: When,
    pub(crate) of: fn(&mut Axis) -> Option<&mut f64>,
}

macro_rules! table {
    ($($when:ident $name:literal $axis:ident => $place:expr;)*) => {
        /// All of them.
        pub(crate) const TABLE: &[Entry] = &[$(Entry {
            name: $name,
            when: When::$when,
            of: |$axis| $place,
        }),*];
    };
}

table! {
    Always "gains.proportional" a => Some(&mut a.gains.proportional);
    Always "gains.integral" a => Some(&mut a.gains.integral);
    Always "gains.derivative" a => Some(&mut a.gains.derivative);
    Always "gains.integral_limit" a => Some(&mut a.gains.integral_limit);
    Always "gains.deadband" a => Some(&mut a.gains.deadband);
    Always "notch.frequency" a => Some(&mut a.notch.frequency);
    Always "notch.width" a => Some(&mut a.notch.width);
    Always "notch.depth" a => Some(&mut a.notch.depth);
    Always "feed_forward.share" a => Some(&mut a.feed_forward.share);
    Always "feed_forward.limit" a => Some(&mut a.feed_forward.limit);
    Always "feed_forward.mass" a => Some(&mut a.feed_forward.mass);
    Always "fade_time" a => Some(&mut a.fade_time);
    Disabled "limits.speed" a => Some(&mut a.limits.speed);
    Disabled "limits.acceleration" a => Some(&mut a.limits.acceleration);
    Disabled "limits.jerk" a => Some(&mut a.limits.jerk);
    Disabled "limits.travel_low" a => a.limits.travel.as_mut().map(|ends| &mut ends.0);
    Disabled "limits.travel_high" a => a.limits.travel.as_mut().map(|ends| &mut ends.1);
    Disabled "duty_limit" a => Some(&mut a.duty_limit);
    Disabled "silence" a => Some(&mut a.silence);
    Disabled "motor.torque_constant" a => Some(&mut a.motor.torque_constant);
    Disabled "motor.resistance" a => Some(&mut a.motor.resistance);
    Disabled "motor.resistance_span" a => Some(&mut a.motor.resistance_span);
    Disabled "motor.inductance" a => Some(&mut a.motor.inductance);
    Disabled "motor.gear_ratio" a => Some(&mut a.motor.gear_ratio);
    Disabled "motor.screw_lead" a => Some(&mut a.motor.screw_lead);
    Disabled "motor.efficiency" a => Some(&mut a.motor.efficiency);
    Disabled "motor.supply" a => Some(&mut a.motor.supply);
    Disabled "hardware.dead_time" a => Some(&mut a.hardware.dead_time);
    Disabled "hardware.diode_drop" a => Some(&mut a.hardware.diode_drop);
    Disabled "watch.top_speed" a => Some(&mut a.watch.top_speed);
    Disabled "watch.following_error" a => Some(&mut a.watch.following_error);
    Disabled "watch.frozen_duty" a => Some(&mut a.watch.frozen_duty);
    Disabled "watch.frozen_time" a => Some(&mut a.watch.frozen_time);
    Disabled "watch.supply_min" a => Some(&mut a.watch.supply_min);
    Disabled "watch.supply_max" a => Some(&mut a.watch.supply_max);
    Disabled "watch.supply_time" a => Some(&mut a.watch.supply_time);
    Disabled "watch.current_max" a => Some(&mut a.watch.current_max);
    Disabled "watch.current_rated" a => Some(&mut a.watch.current_rated);
    Disabled "watch.thermal_time" a => Some(&mut a.watch.thermal_time);
    Disabled "watch.current_offset" a => Some(&mut a.watch.current_offset);
}

const COUNT: usize = TABLE.len();

/// Bytes of a record: which model, the parameters, and as many of a model as there may be.
const RECORD: usize = 4 * (1 + COUNT + MOST_PARAMETERS);

impl Entry {
    pub(crate) fn find(name: &Name) -> Option<&'static Entry> {
        TABLE.iter().find(|entry| entry.name == name.as_str())
    }

    pub(crate) fn read(&self, axis: &Axis) -> Option<Parameter> {
        let value = *(self.of)(&mut axis.clone())?;
        Some(Parameter {
            name: Name::new(self.name)?,
            value: value as f32,
            settable: true,
        })
    }
}

/// Parameters and friction model as they are saved: NaN for what there is not.
#[derive(Clone, Debug)]
pub struct Parameters {
    /// [`Table::origin`](crate::Table::origin).
    origin: u32,
    values: [f32; COUNT],
    model: [f32; MOST_PARAMETERS],
}

impl Parameters {
    /// Of the record's layout: another table of names makes another version, whose records are not read (FNV-1a).
    pub const VERSION: u32 = {
        let mut hash = 0x811C_9DC5_u32;
        let mut entry = 0;
        while entry < COUNT {
            let name = TABLE[entry].name.as_bytes();
            let mut byte = 0;
            while byte < name.len() {
                hash = fnv(hash, name[byte] as u32);
                byte += 1;
            }
            entry += 1;
        }
        hash
    };

    pub(crate) fn of<M: Model>(axis: &Axis, model: &M) -> Self {
        let (mut axis, mut model) = (*axis, model.clone());
        let table = model.table();
        let mut saved = Self {
            origin: table.origin,
            values: [f32::NAN; COUNT],
            model: [f32::NAN; MOST_PARAMETERS],
        };
        for (value, entry) in saved.values.iter_mut().zip(TABLE) {
            // Travel ends that are not there stay NaN, and are not set.
            if let Some(own) = (entry.of)(&mut axis) {
                *value = *own as f32;
            }
        }
        for (value, own) in saved.model.iter_mut().zip(table.values) {
            *value = *own as f32;
        }
        saved
    }

    /// What these make of what was compiled in. A model that they were not saved over stays as it was compiled in.
    pub(crate) fn over<M: Model>(&self, axis: &Axis, model: &M) -> (Axis, M) {
        let (mut axis, mut model) = (*axis, model.clone());
        for (value, entry) in self.values.iter().zip(TABLE) {
            if let Some(place) = (entry.of)(&mut axis) {
                place_value(place, *value);
            }
        }
        let table = model.table();
        if table.origin == self.origin {
            for (place, value) in table.values.iter_mut().zip(self.model) {
                place_value(place, value);
            }
        }
        (axis, model)
    }

    /// As bytes.
    pub fn to_bytes(&self) -> [u8; RECORD] {
        let mut bytes = [0; RECORD];
        let numbers = self.values.iter().chain(&self.model);
        let words = core::iter::once(self.origin).chain(numbers.map(|number| number.to_bits()));
        for (place, word) in bytes.chunks_exact_mut(4).zip(words) {
            place.copy_from_slice(&word.to_le_bytes());
        }
        bytes
    }

    /// From bytes; `None` where they are fewer or more.
    pub fn from_bytes(bytes: &[u8]) -> Option<Self> {
        if bytes.len() != RECORD {
            return None;
        }
        let mut words = bytes
            .chunks_exact(4)
            .filter_map(|chunk| Some(u32::from_le_bytes(*chunk.first_chunk()?)));
        let mut saved = Self {
            origin: words.next()?,
            values: [0.0; COUNT],
            model: [0.0; MOST_PARAMETERS],
        };
        let places = saved.values.iter_mut().chain(&mut saved.model);
        for (place, word) in places.zip(words) {
            *place = f32::from_bits(word);
        }
        Some(saved)
    }
}

/// Sets it, unless it is the same number in single precision already: what was compiled in has more digits.
pub(crate) fn place_value(place: &mut f64, value: f32) {
    if !value.is_nan() && *place as f32 != value {
        *place = value.into();
    }
}
