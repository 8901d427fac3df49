//! Metrics of the sensors and their inputs: state, registration and learnt errors.

use super::text::Metrics;
use fusion::learning::{LearntType, LearntValue};
use fusion::registration::Misalignment;
use service::live::{
    LineStatus, RegistrationStatus, SensorState, SensorStatus, VelocityUse, of_data_sheet, type_name, values,
    velocity_errors,
};

impl Metrics {
    /// All metrics of the sensors.
    pub(super) fn all_of_sensors(&mut self, sensors: &[SensorStatus]) {
        self.sensors(sensors);
        self.registrations(sensors);
        self.learnt(sensors);
        self.types(sensors);
        self.lines(sensors);
    }

    fn sensors(&mut self, sensors: &[SensorStatus]) {
        let state = |sensor: &SensorStatus| match sensor.state {
            SensorState::Outage => 0,
            SensorState::Degraded => 1,
            SensorState::Operational => 2,
        };
        let states = sensors.iter().map(|sensor| (&sensor.id, state(sensor)));
        self.by("sensor_state", "0 outage, 1 degraded, 2 operational", "sensor", states);
        let rates = sensors.iter().map(|sensor| (&sensor.id, sensor.rate_hz));
        self.by("sensor_rate_hertz", "Reports per second over the last 10 s", "sensor", rates);
        let offsets = sensors.iter().filter_map(|sensor| Some((&sensor.id, sensor.clock_offset_s?)));
        self.by("sensor_clock_offset_seconds", "Least delay of the last reports", "sensor", offsets);
    }

    /// Registration of the radars. Angles are in degrees, as in the configuration.
    fn registrations(&mut self, sensors: &[SensorStatus]) {
        let known: Vec<_> = sensors.iter().filter_map(registered).collect();
        if known.is_empty() {
            return;
        }
        let names = [
            ("bearing", "degrees"),
            ("tilt_east", "degrees"),
            ("tilt_north", "degrees"),
            ("range", "metres"),
            ("height", "metres"),
            ("time", "seconds"),
        ];
        for (index, (name, unit)) in names.into_iter().enumerate() {
            let estimated = || known.iter().map(|(id, _, estimate)| (id, values(estimate)[index].2));
            let biases = estimated().map(|(id, value)| (id, value.value));
            let help = "A radar's bias, measured minus true";
            self.by(&format!("registration_{name}_{unit}"), help, "sensor", biases);
            let deviations = estimated().map(|(id, value)| (id, value.deviation));
            let help = "Standard deviation of the bias";
            self.by(&format!("registration_{name}_deviation_{unit}"), help, "sensor", deviations);
        }
        self.family("registration_observable", "Whether a bias is known well enough");
        for (sensor, _, estimate) in &known {
            for ((name, _), (.., value)) in names.into_iter().zip(values(estimate)) {
                let labels = [("sensor", sensor.as_str()), ("value", name)];
                self.sample("registration_observable", &labels, u8::from(value.observable));
            }
        }
        let tracks = known.iter().map(|(id, _, estimate)| (id, estimate.samples));
        self.by("registration_tracks", "Radar tracks that it rests upon", "sensor", tracks);
        let residuals = known.iter().filter_map(|(id, _, estimate)| Some((id, estimate.residual?)));
        self.by("registration_residual", "1: as the configured errors predict", "sensor", residuals);
        let applied = known.iter().map(|(id, registration, _)| (id, u8::from(registration.is_applied())));
        self.by("registration_applied", "Whether plots are corrected by it", "sensor", applied);
        let steps = known.iter().map(|(id, registration, _)| (id, registration.steps));
        self.by("registration_steps_total", "Times that it has begun anew", "sensor", steps);
    }

    /// Learnt errors of the radars.
    fn learnt(&mut self, sensors: &[SensorStatus]) {
        let learnt =
            |sensor: &'_ SensorStatus| Some((sensor.id.clone(), sensor.registration.as_ref()?.learnt?));
        let known: Vec<_> = sensors.iter().filter_map(learnt).collect();
        if known.is_empty() {
            return;
        }
        type Part = fn(&LearntValue) -> f64;
        let parts: [(&str, &str, Part); 2] = [
            ("learnt_of_data_sheet", "A radar's errors over those of its data sheet", |value| value.value),
            ("learnt_of_data_sheet_deviation", "Standard deviation of that", |value| value.deviation),
        ];
        for (name, help, part) in parts {
            self.family(name, help);
            for (sensor, learnt) in &known {
                for (axis, value) in of_data_sheet(learnt) {
                    self.sample(name, &[("sensor", sensor.as_str()), ("axis", axis)], part(&value));
                }
            }
        }
        let tracks = known.iter().map(|(id, learnt)| (id, learnt.azimuth.tracks));
        self.by("learnt_tracks", "Independent samples that it rests upon", "sensor", tracks);
        let used = known
            .iter()
            .map(|(id, learnt)| (id, u8::from(VelocityUse::from(&learnt.velocity) == VelocityUse::Used)));
        self.by("learnt_velocity_used", "Whether a radar's velocities are used", "sensor", used);
        let off =
            known.iter().filter_map(|(id, learnt)| Some((id, velocity_errors(&learnt.velocity)?.sigma_m_s)));
        self.by("learnt_velocity_error_metres_per_second", "How far they are off, each axis", "sensor", off);
    }

    /// Learnt errors of the types of transponders.
    fn types(&mut self, sensors: &[SensorStatus]) {
        type Part = (&'static str, fn(&LearntType) -> f64);
        let families: [(&str, &str, &[Part]); 2] = [
            (
                "learnt_transponder_noise_metres",
                "White noise of a type of transponders, each axis",
                &[
                    ("horizontal", |learnt| learnt.horizontal_m.value),
                    ("vertical", |learnt| learnt.vertical_m.value),
                ],
            ),
            (
                "learnt_transponder_delay_seconds",
                "How late the times of a type of transponders are",
                &[
                    ("value", |learnt| learnt.delay_s.value),
                    ("deviation", |learnt| learnt.delay_s.deviation),
                    ("applied", |learnt| learnt.applied_s),
                ],
            ),
        ];
        if sensors.iter().all(|sensor| sensor.types.is_empty()) {
            return;
        }
        for (name, help, parts) in families {
            self.family(name, help);
            for sensor in sensors {
                for (kind, learnt) in &sensor.types {
                    for (part, number) in parts {
                        let labels =
                            [("sensor", sensor.id.as_str()), ("type", &type_name(kind)), ("part", part)];
                        self.sample(name, &labels, number(learnt));
                    }
                }
            }
        }
    }

    /// Metrics of the inputs. Sensors may share an input; each input is written once.
    fn lines(&mut self, sensors: &[SensorStatus]) {
        let mut lines: Vec<&LineStatus> = sensors.iter().flat_map(|sensor| &sensor.lines).collect();
        lines.sort_by(|a, b| a.name.cmp(&b.name));
        lines.dedup_by(|a, b| a.name == b.name);
        type Count = fn(&LineStatus) -> u64;
        let counts: [(&str, &str, Count); 6] = [
            ("line_joined", "Whether the line is open", |line| u64::from(line.joined)),
            ("line_received_total", "Datagrams", |line| line.received),
            ("line_duplicate_total", "Copies of another line's", |line| line.duplicates),
            ("line_foreign_total", "Datagrams of other hosts", |line| line.foreign),
            ("line_queue_full_total", "Datagrams lost in the queue", |line| line.queue_full),
            ("line_kernel_dropped_total", "Datagrams lost in the kernel", |line| line.kernel_dropped),
        ];
        for (name, help, count) in counts {
            self.by(name, help, "line", lines.iter().map(|line| (&line.name, count(line))));
        }
        self.family("line_untranslated_total", "What a translator at the door dropped");
        for line in &lines {
            for (reason, count) in &line.untranslated {
                self.sample("line_untranslated_total", &[("line", &line.name), ("reason", reason)], *count);
            }
        }
    }
}

/// Id and registration of a sensor whose misalignment is estimated.
fn registered(sensor: &SensorStatus) -> Option<(&String, &RegistrationStatus, &Misalignment)> {
    let registration = sensor.registration.as_ref()?;
    Some((&sensor.id, registration, registration.estimate.as_ref()?))
}
