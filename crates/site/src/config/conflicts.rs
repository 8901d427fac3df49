//! `[conflicts]`.

use conflict::{
    AcceptedKinds, ConflictRules, Extrapolation, LevelThreshold, Preset, SteadyFlightRatios, Volume,
};

use super::network::PictureKind;
use super::{Fusion, Profile};
use tables::kinds::{Kind, any_text, flag, inline, list, named, number, tables};
use tables::reader::Section;
use tables::section;
use tables::table::{ByHand, absent, depends};
use tables::{names, written_by_name};

fn density() -> Kind<f64> {
    number("a density of acceleration is at least 0, and at most 100 m²/s³", |v| (0.0..=100.0).contains(&v))
}

fn share() -> Kind<f64> {
    number("a probability is above 0, and at most 1", |v| v > 0.0 && v <= 1.0)
}

fn ahead_s() -> Kind<f64> {
    number("a time ahead is above 0, and at most 300 seconds", |v| v > 0.0 && v <= 300.0)
}

fn metres() -> Kind<f64> {
    number("a volume is above 0 and at most 20000 metres", |v| v > 0.0 && v <= 20_000.0)
}

section! {
    /// Prediction of conflicts between aircraft (docs/CONFLICTS.md). Not used by the `reference` profile.
    Conflicts {
        /// Whether conflicts are predicted.
        enabled: bool = false, flag();
        /// Picture from which conflicts are predicted. The tracks of `"lagged"` are first extrapolated by `latency_s`.
        picture: PictureKind = PictureKind::Now, named();
        /// Prediction horizon, in seconds.
        horizon_s: f64 = 60.0, ahead_s();
        /// Power spectral density of the horizontal acceleration with which aircraft turn, in m²/s³ per axis.
        acceleration: f64 = 1.0, density();
        /// Mean time for which both aircraft of a pair fly straight, in seconds, until their past is known.
        straight_s: f64 = 30.0, ahead_s();
        /// Thresholds of an advisory: minimum probability and maximum time to the entry of the volume.
        advisory: Advisory = Advisory::default(), inline::<Advisory>();
        /// Thresholds of a warning, as for an advisory. The level above, a violation, means that a volume is entered.
        warning: Warning = Warning::default(), inline::<Warning>();
        /// Protected volumes around aircraft. Without any, there is one of 50 m by 15 m between drones, and `f3442` between
        /// drones and crewed aircraft.
        volumes: Vec<ConflictVolume> = Vec::new(), tables();
        /// Serial numbers of transponders on crewed aircraft. Other aircraft are crewed if their reports say so (ADS-B),
        /// otherwise drones.
        crewed: Vec<String> = Vec::new(), list(any_text());
    } by hand {}
}

section! {
    /// Thresholds of an advisory.
    #[derive(Copy)]
    Advisory {
        /// Minimum probability of a conflict.
        probability: f64 = 0.1, share();
        /// Maximum time to the entry of the volume, in seconds.
        time_s: f64 = 60.0, ahead_s();
    }
}

section! {
    /// Thresholds of a warning.
    #[derive(Copy)]
    Warning {
        /// Minimum probability of a conflict.
        probability: f64 = 0.12, share();
        /// Maximum time to the entry of the volume, in seconds.
        time_s: f64 = 20.0, ahead_s();
    }
}

section! {
    /// Cylinder around an aircraft. A `preset` supplies the dimensions that are not given.
    ConflictVolume {
        /// Standard volume to start from.
        preset: Option<VolumePreset> = absent("the numbers below"), named::<VolumePreset>();
        /// Name of the volume.
        name: Option<String> = absent("that of the preset"), any_text();
        /// Radius, in metres.
        horizontal_m: Option<f64> = absent("that of the preset"), metres();
        /// Half of the height, in metres.
        vertical_m: Option<f64> = absent("that of the preset"), metres();
        /// Maximum modified tau, in seconds, at which approaching aircraft have entered the volume. 0 disables it.
        tau_s: Option<f64> = absent("that of the preset, or 0"),
            number("tau is between 0 and 300 seconds", |v| (0.0..=300.0).contains(&v));
        /// The two kinds of aircraft that the volume applies to.
        between: Vec<VolumeSide> = depends("any two with a preset, two drones without", Vec::new()), list(named());
    } by hand {}
}

names! {
    /// Standard volumes.
    #[derive(Copy, Eq)]
    VolumePreset, "preset" {
        /// Well clear in en-route airspace, with modified tau (DO-365B, figures as in NASA DAIDALUS).
        Enroute = "do365-enroute",
        /// Well clear in terminal areas (DO-365B, figures as in NASA DAIDALUS).
        Terminal = "do365-terminal",
        /// Well clear of aircraft without a transponder (DO-365B, figures as in NASA DAIDALUS).
        Noncooperative = "do365-noncooperative",
        /// Well clear of small drones (ASTM F3442, figures from reviews).
        F3442 = "f3442",
        /// Near mid-air collision (figures as in NASA DAIDALUS).
        Nmac = "nmac",
    }
}

names! {
    /// Kind of aircraft that a volume applies to.
    #[derive(Copy, Eq)]
    VolumeSide, "kind of aircraft" {
        /// Unmanned aircraft.
        Drone = "drone",
        /// Aircraft with people on board.
        Crewed = "crewed",
        /// Any aircraft.
        Any = "any",
    }
}
written_by_name!(VolumePreset, VolumeSide);

impl From<VolumePreset> for Preset {
    fn from(preset: VolumePreset) -> Self {
        match preset {
            VolumePreset::Enroute => Self::Do365Enroute,
            VolumePreset::Terminal => Self::Do365Terminal,
            VolumePreset::Noncooperative => Self::Do365Noncooperative,
            VolumePreset::F3442 => Self::F3442,
            VolumePreset::Nmac => Self::Nmac,
        }
    }
}

impl From<VolumeSide> for AcceptedKinds {
    fn from(side: VolumeSide) -> Self {
        match side {
            VolumeSide::Drone => Self::Only(conflict::TrafficKind::Drone),
            VolumeSide::Crewed => Self::Only(conflict::TrafficKind::Crewed),
            VolumeSide::Any => Self::Any,
        }
    }
}

/// Rejects keys that contradict each other.
impl ByHand for Conflicts {
    fn more(&mut self, section: &mut Section<'_>) {
        let (advisory, warning) = (self.advisory, self.warning);
        if advisory.probability > warning.probability || advisory.time_s < warning.time_s {
            section.contradict(
                &["advisory", "warning"],
                "an advisory is given before a warning: its probability is at most that of the warning, its time at least",
            );
        }
        if self.horizon_s < warning.time_s {
            section.contradict(
                &["horizon_s", "warning"],
                "nothing is warned of that lies beyond horizon_s; raise it, or lower time_s of the warning",
            );
        }
        let volumes = self.volumes();
        if let Some(volume) = volumes.iter().find(|volume| volume.tau_s > self.horizon_s) {
            section.contradict(
                &["horizon_s", "volumes"],
                format!(
                    "volume \"{}\" counts as entered {} s before, which nobody finds who looks {} s ahead; raise horizon_s",
                    volume.name, volume.tau_s, self.horizon_s
                ),
            );
        }
        let mut names: Vec<String> = volumes.into_iter().map(|volume| volume.name).collect();
        names.sort();
        if let Some(twice) = names.windows(2).find(|two| two[0] == two[1]) {
            section.contradict(
                &["volumes"],
                format!("two volumes are called \"{}\"; give each a name", twice[0]),
            );
        }
    }
}

impl ByHand for ConflictVolume {
    fn more(&mut self, section: &mut Section<'_>) {
        let is_whole = self.horizontal_m.and(self.vertical_m).is_some() && self.name.is_some();
        if self.preset.is_none() && !is_whole {
            for (name, add) in [
                ("name", "name = …, or a preset"),
                ("horizontal_m", "horizontal_m = …, or a preset"),
                ("vertical_m", "vertical_m = …, or a preset"),
            ] {
                section.need(name, add);
            }
        }
        if !matches!(self.between.len(), 0 | 2) {
            section.contradict(&["between"], "a volume is between two: [\"drone\", \"crewed\"]");
        }
    }
}

impl ConflictVolume {
    fn volume(&self) -> Volume {
        let preset = self.preset.map(|preset| Preset::from(preset).volume());
        let of_own = Volume {
            name: String::new(),
            horizontal_m: 0.0,
            vertical_m: 0.0,
            tau_s: 0.0,
            between: [VolumeSide::Drone.into(); 2],
        };
        let mut volume = preset.unwrap_or(of_own);
        if let Some(name) = &self.name {
            volume.name.clone_from(name);
        }
        let numbers = [
            (&mut volume.horizontal_m, self.horizontal_m),
            (&mut volume.vertical_m, self.vertical_m),
            (&mut volume.tau_s, self.tau_s),
        ];
        for (number, given) in numbers {
            *number = given.unwrap_or(*number);
        }
        if let [one, other] = self.between[..] {
            volume.between = [one.into(), other.into()];
        }
        volume
    }
}

impl Conflicts {
    /// Rules by which conflicts are found.
    pub fn rules(&self) -> ConflictRules {
        let Self { horizon_s, acceleration, straight_s, advisory, warning, .. } = *self;
        ConflictRules {
            volumes: self.volumes(),
            ahead: Extrapolation {
                horizon_s,
                acceleration,
                straight_s,
                steady: SteadyFlightRatios::MEASURED,
            },
            advisory: LevelThreshold { probability: advisory.probability, time_s: advisory.time_s },
            warning: LevelThreshold { probability: warning.probability, time_s: warning.time_s },
        }
    }

    fn volumes(&self) -> Vec<Volume> {
        if !self.volumes.is_empty() {
            return self.volumes.iter().map(ConflictVolume::volume).collect();
        }
        let drones = ConflictVolume {
            name: Some("drone".to_owned()),
            horizontal_m: Some(50.0),
            vertical_m: Some(15.0),
            ..ConflictVolume::default()
        };
        let crewed = ConflictVolume {
            preset: Some(VolumePreset::F3442),
            name: Some("crewed".to_owned()),
            between: vec![VolumeSide::Drone, VolumeSide::Crewed],
            ..ConflictVolume::default()
        };
        [drones, crewed].iter().map(ConflictVolume::volume).collect()
    }

    /// Whether conflicts are enabled on a picture that the engine does not produce.
    pub(super) fn lacks_now(&self, fusion: &Fusion) -> bool {
        self.enabled
            && fusion.profile == Profile::Operational
            && self.picture == PictureKind::Now
            && !fusion.now
    }
}
