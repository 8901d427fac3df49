//! `[output]` and `[state]`.

use std::path::PathBuf;

use super::network::{Feed, PictureKind, Sink};
use super::receivers::MqttTracks;
use super::sinks::{Cot, F3623, Sapient};
use crate::picture::MAX_ACCURACY_M;
use tables::kinds::{directory, flag, inline, named, number, tables, whole};
use tables::section;
use tables::table::{absent, need};
use tables::{names, written_by_name};

section! {
    /// What is sent and recorded.
    Output {
        /// Destinations of the fused tracks. One that cannot be opened at SIGHUP leaves those before.
        asterix: Vec<Sink> = Vec::new(), tables(), reloaded;
        /// Receivers of Cursor on Target events, one per track and second.
        cot: Vec<Cot> = Vec::new(), tables();
        /// Receivers of observations for surveillance supplementary data (ASTM F3623), a post per second.
        f3623: Vec<F3623> = Vec::new(), tables();
        /// Nodes that get SAPIENT detection reports, one per track and second.
        sapient: Vec<Sapient> = Vec::new(), tables();
        /// Brokers of MQTT 5 that get a message per track and second.
        mqtt: Vec<MqttTracks> = Vec::new(), tables();
        /// What I129/040 of a record with a transponder holds.
        serial: SerialSource = SerialSource::Uas, named();
        /// Of positions that no sensor measured in their slot (interpolated, extrapolated) those are left out, here and in the
        /// files of `replay`, whose horizontal 95 % radius is above this, metres. The API has a parameter of this name.
        max_accuracy_m: f64 = MAX_ACCURACY_M,
            number("an accuracy is a radius of 1 to 10000 metres", |metres| (1.0..=10_000.0).contains(&metres));
        /// Whether the destinations get a CAT065 service status each second, so that silence is a failure, and those of CAT062
        /// the CAT063 status of the sensors.
        status: bool = true, flag();
        /// Whether the slots that the window still holds are published when the service stops.
        flush_on_stop: bool = true, flag();
        /// Recording of what arrives, into rotating capture files.
        record: Option<Record> = absent("nothing is recorded"), inline::<Record>();
    }
}

impl Output {
    /// The first destination that gets this.
    pub fn sink(&self, feed: Feed) -> Option<&Sink> {
        self.asterix.iter().find(|sink| sink.feed() == feed)
    }

    /// The keys under which somebody wants the picture of now.
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
    /// What I129/040 of a fused or transponder-only record holds.
    #[derive(Copy, Eq)]
    SerialSource, "source of serials" {
        /// The serial of the aircraft itself.
        Uas = "uas",
        /// The track number, for readers that know only this item.
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
        /// Size at which a new file starts, MiB.
        rotate_mib: u32 = 256, whole("a file grows to a whole number of MiB, 1 to 1048576", 1..=1_048_576);
        /// How many full recordings are kept, the newest ones. A recording is full at `rotate_mib` or after an hour; one that a
        /// restart ended earlier counts as its share of that.
        keep: u32 = 16, whole("the recordings kept are a whole number, 1 to 1000000", 1..=1_000_000);
        /// Most that all recordings together take, MiB; beyond it the oldest are removed. 0 for no limit.
        keep_mib: u32 = 0, whole("the recordings take a whole number of MiB, 0 (no limit) to 1073741824", 0..=1_073_741_824);
        /// Time after which a recording is removed, hours; 0 for no limit.
        keep_hours: u32 = 0, whole("recordings are kept for a whole number of hours, 0 (no limit) to 87840", 0..=87_840);
    }
}

section! {
    /// What outlives a restart: track numbers, misalignment, decisions of the operator, and the history of the picture. Limits
    /// of the history can be changed by SIGHUP, but a history is begun or ended by a restart only.
    Persistence {
        /// Directory of the kept files.
        dir: PathBuf = PathBuf::from("state"), directory();
        /// Seconds between two checkpoints of the engine, from which a restart within 25 s goes on; 0 for none.
        checkpoint_s: f64 = 30.0,
            number("a checkpoint is written every 1 to 600 s, or 0 (none)", |seconds| seconds == 0.0 || (1.0..=600.0).contains(&seconds));
        /// Length of the history (trails, and one past picture per second), hours; 0 for none.
        history_hours: f64 = 24.0,
            number("the history goes back 0 (none) to 8784 hours", |hours| (0.0..=8784.0).contains(&hours)), reloaded;
        /// Approximate limit of the history on disk, MiB.
        history_mib: u32 = 512, whole("the history takes a whole number of MiB, 1 to 1048576", 1..=1_048_576), reloaded;
    }
}
