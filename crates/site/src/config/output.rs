//! `[output]` and `[state]`.

use std::path::PathBuf;

use super::network::{Feed, PictureKind, Sink};
use super::receivers::MqttTracks;
use super::sinks::{Cot, F3623, Sapient};
use tables::kinds::{directory, flag, inline, named, number, tables, whole};
use tables::section;
use tables::table::{absent, need};
use tables::{names, written_by_name};

/// Default of `max_accuracy_m`, for outputs and clients of the API, metres.
pub const MAX_ACCURACY_M: f64 = 100.0;

section! {
    /// Outputs and recording.
    Output {
        /// UDP destinations of the fused tracks. If one cannot be opened at SIGHUP, the previous destinations stay.
        asterix: Vec<Sink> = Vec::new(), tables(), reloaded;
        /// Receivers of Cursor on Target events, one event per track and second.
        cot: Vec<Cot> = Vec::new(), tables();
        /// Receivers of surveillance supplementary data (ASTM F3623), one post per second.
        f3623: Vec<F3623> = Vec::new(), tables();
        /// SAPIENT nodes that receive detection reports, one per track and second.
        sapient: Vec<Sapient> = Vec::new(), tables();
        /// MQTT 5 brokers that receive one message per track and second.
        mqtt: Vec<MqttTracks> = Vec::new(), tables();
        /// Content of I129/040 in records of tracks with a transponder.
        serial: SerialSource = SerialSource::Uas, named();
        /// Maximum horizontal accuracy (95 % radius) of positions that no sensor measured in their slot, in metres. Less accurate
        /// interpolated or extrapolated positions are not sent, nor written to the files of `replay`. The API has a parameter of
        /// this name.
        max_accuracy_m: f64 = MAX_ACCURACY_M,
            number("an accuracy is a radius of 1 to 10000 metres", |metres| (1.0..=10_000.0).contains(&metres));
        /// Whether destinations receive a CAT065 service status every second, so that silence is a failure. Destinations with
        /// CAT062 receive the CAT063 sensor status too.
        status: bool = true, flag();
        /// Whether the slots still in the window are published when the service stops.
        flush_on_stop: bool = true, flag();
        /// Recording of received data into rotating capture files.
        record: Option<Record> = absent("nothing is recorded"), inline::<Record>();
    }
}

impl Output {
    /// The first destination with this content.
    pub fn sink(&self, feed: Feed) -> Option<&Sink> {
        self.asterix.iter().find(|sink| sink.feed() == feed)
    }

    /// Keys of `[output]` with a destination that receives the picture "now".
    pub(super) fn sinks_of_now(&self) -> Vec<&'static str> {
        let is_now = |picture| picture == PictureKind::Now;
        let keys = [
            ("asterix", self.asterix.iter().any(|sink| is_now(sink.picture))),
            ("cot", self.cot.iter().any(|sink| is_now(sink.picture))),
            ("f3623", self.f3623.iter().any(|sink| is_now(sink.picture))),
            ("sapient", self.sapient.iter().any(|sink| is_now(sink.picture))),
            ("mqtt", self.mqtt.iter().any(|sink| is_now(sink.picture))),
        ];
        keys.into_iter().filter_map(|(key, wants)| wants.then_some(key)).collect()
    }
}

names! {
    /// Content of I129/040 in a fused or transponder-only record.
    #[derive(Copy, Eq)]
    SerialSource, "source of serials" {
        /// Serial number of the aircraft.
        Uas = "uas",
        /// Track number, for readers that use only this item.
        TrackNumber = "track-number",
    }
}
written_by_name!(SerialSource);

section! {
    /// Recording into rotating capture files.
    #[derive(Eq)]
    Record {
        /// Directory of the recordings.
        dir: PathBuf = need("dir = …, the directory of the recordings"), directory();
        /// Size at which a new file is started, in MiB.
        rotate_mib: u32 = 256, whole("a file grows to a whole number of MiB, 1 to 1048576", 1..=1_048_576);
        /// Number of full recordings to keep, newest first. A recording is full at `rotate_mib` or after an hour. One that a
        /// restart ended earlier counts in proportion.
        keep: u32 = 16, whole("the recordings kept are a whole number, 1 to 1000000", 1..=1_000_000);
        /// Maximum size of all recordings together, in MiB. The oldest are removed. 0 disables the limit.
        keep_mib: u32 = 0, whole("the recordings take a whole number of MiB, 0 (no limit) to 1073741824", 0..=1_073_741_824);
        /// Time after which a recording is removed, in hours. 0 disables the limit.
        keep_hours: u32 = 0, whole("recordings are kept for a whole number of hours, 0 (no limit) to 87840", 0..=87_840);
    }
}

section! {
    /// State kept across restarts: track numbers, misalignment of radars, operator decisions, and the history of the picture.
    /// SIGHUP changes the limits of the history; enabling or disabling it needs a restart.
    Persistence {
        /// Directory of the state files.
        dir: PathBuf = PathBuf::from("state"), directory();
        /// Time between two checkpoints of the engine, in seconds. After a restart within 25 s the engine continues from the last
        /// one. 0 disables checkpoints.
        checkpoint_s: f64 = 30.0,
            number("a checkpoint is written every 1 to 600 s, or 0 (none)", |seconds| seconds == 0.0 || (1.0..=600.0).contains(&seconds));
        /// Length of the history (trails, and one past picture per second), in hours. 0 disables it.
        history_hours: f64 = 24.0,
            number("the history goes back 0 (none) to 8784 hours", |hours| (0.0..=8784.0).contains(&hours)), reloaded;
        /// Approximate maximum size of the history on disk, in MiB.
        history_mib: u32 = 512, whole("the history takes a whole number of MiB, 1 to 1048576", 1..=1_048_576), reloaded;
    }
}
