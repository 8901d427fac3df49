//! One radar's detections of one target, with their errors.

use nalgebra::Vector2;

use crate::ground::{Antenna, Ground};
use crate::radar_detection::{RadarDetection, RadarTarget, clock_s};
use crate::scenario::{Radar, Span, VelocityModel};
use crate::streams::{GaussMarkov, RandomStream};

/// Time constant with which errors grow in a turn and decay after it, seconds.
const TURN_S: f64 = 1.0;

/// State of one radar for one target.
#[derive(Clone, Debug)]
pub struct TargetState {
    stream: RandomStream,
    /// Separate stream for frozen velocities, so that they change nothing else.
    inventions: RandomStream,
    /// Whether the target is currently visible.
    seen: bool,
    observed_s: f64,
    /// Mean UAV probability that this radar reports for the target.
    uav_probability: f64,
    track: Option<RadarTrack>,
    /// Number of a track that has just ended.
    ended: Option<u16>,
}

#[derive(Clone, Debug)]
struct RadarTrack {
    number: u16,
    detected_s: f64,
    detections: u32,
    azimuth: GaussMarkov,
    range: GaussMarkov,
    height: GaussMarkov,
    /// Factor of the azimuth error, from 1 to the radar's turn factor.
    turning: f64,
    /// Velocity that is reported if velocities are frozen, east and north, m/s.
    frozen_velocity: Vector2<f64>,
    uav_probability: f64,
    /// Time of the next seduction.
    seduced_from_s: f64,
    seduction: Option<Seduction>,
}

/// A seduction: the track leaves its target.
#[derive(Clone, Copy, Debug)]
struct Seduction {
    from_s: f64,
    until_s: f64,
    /// Velocity of the track, east and north, m/s.
    velocity: Vector2<f64>,
}

/// One observation of a target by a radar.
pub struct TargetObservation<'a> {
    /// The radar.
    pub radar: &'a Radar,
    /// Antenna of the radar.
    pub antenna: &'a Antenna,
    /// The ground.
    pub ground: &'a Ground,
    /// The target.
    pub target: &'a RadarTarget,
    /// Time since take-off, s.
    pub time_s: f64,
}

impl TargetState {
    /// State before the first look.
    pub fn new(
        radar: &Radar,
        target: &RadarTarget,
        mut stream: RandomStream,
        inventions: RandomStream,
    ) -> Self {
        let share = radar.seen_s / (radar.seen_s + radar.unseen_s);
        let low = target.drone.is_some() && stream.chance(radar.low_share);
        let uav_probability = match target.drone {
            Some(_) if low => stream.within(radar.low_probability),
            Some(_) => stream.within(radar.drone_probability),
            None => target.uav_probability,
        };
        let seen = stream.chance(share);
        Self { stream, inventions, seen, observed_s: 0.0, uav_probability, track: None, ended: None }
    }

    /// Number of the track on the target.
    pub fn number(&self) -> Option<u16> {
        self.track.as_ref().map(|track| track.number)
    }

    /// Changes the number of the track.
    pub fn renumber(&mut self, number: Option<u16>) {
        if let (Some(track), Some(number)) = (&mut self.track, number) {
            track.number = number;
        }
    }

    /// Returns the number of a track that has ended, once.
    pub fn take_ended(&mut self) -> Option<u16> {
        self.ended.take()
    }

    /// Observes the target once; `new_number` supplies the number of a new track.
    pub fn observe(
        &mut self,
        observation: &TargetObservation<'_>,
        new_number: impl FnOnce() -> Option<u16>,
    ) -> Option<RadarDetection> {
        let TargetObservation { radar, target, time_s, .. } = *observation;
        let hovers = target.path.hovers(time_s);
        self.pass(radar, time_s, hovers);
        self.follow(radar, time_s);
        if !self.seen || !self.stream.chance(radar.detection) {
            return None;
        }
        if self.track.is_none() {
            self.track = Some(self.begin(radar, time_s, new_number()?));
        }
        let track = self.track.as_mut()?;
        track.detected_s = time_s;
        track.detections += 1;
        let detection = track.measure(observation, &mut self.stream);
        (track.detections >= radar.confirmed_by).then_some(detection)
    }

    /// Alternates between visible and invisible periods; visible periods are shorter for a hovering target.
    fn pass(&mut self, radar: &Radar, time_s: f64, hovers: bool) {
        let past_s = time_s - self.observed_s;
        self.observed_s = time_s;
        if self.track.as_ref().is_some_and(|track| track.seduction.is_some()) {
            return; // a seduced track continues until the seduction ends
        }
        let mean_s = match self.seen {
            true if hovers => radar.seen_s / radar.hover_factor,
            true => radar.seen_s,
            false => radar.unseen_s,
        };
        if self.stream.chance(1.0 - (-past_s / mean_s).exp()) {
            self.seen = !self.seen;
        }
    }

    /// Drops a lost track, and begins seductions.
    fn follow(&mut self, radar: &Radar, time_s: f64) {
        let Some(track) = &mut self.track else { return };
        let lost = time_s - track.detected_s > radar.drop_after_s;
        let walked_off = track.seduction.is_some_and(|walk| time_s >= walk.until_s);
        if lost || walked_off {
            self.ended = Some(track.number);
            self.track = None;
            // The radar has followed something else, so the target itself has to be detected again.
            self.seen &= !walked_off;
        } else if track.seduction.is_none() && time_s >= track.seduced_from_s {
            let velocity = any_velocity(&mut self.stream, radar.seduction_m_s);
            track.seduction = Some(Seduction {
                from_s: time_s,
                until_s: time_s + self.stream.within(radar.seduction_s),
                velocity,
            });
        }
    }

    fn begin(&mut self, radar: &Radar, time_s: f64, number: u16) -> RadarTrack {
        let stream = &mut self.stream;
        let mut slow = |deviation| GaussMarkov::new(deviation, radar.track_time_s, time_s, stream);
        let (azimuth, range, height) =
            (slow(radar.track_azimuth_deg), slow(radar.track_range_m), slow(radar.track_height_m));
        let every_s = if radar.seduction_every_s > 0.0 { radar.seduction_every_s } else { f64::INFINITY };
        RadarTrack {
            number,
            detected_s: time_s,
            detections: 0,
            azimuth,
            range,
            height,
            turning: 1.0,
            frozen_velocity: any_velocity(&mut self.inventions, radar.velocity_frozen_m_s),
            // A probability of exactly 0 stays 0.
            uav_probability: if self.uav_probability > 0.0 {
                self.uav_probability + stream.normal(radar.track_probability)
            } else {
                0.0
            },
            seduced_from_s: time_s + stream.exponential(every_s),
            seduction: None,
        }
    }
}

/// Random direction; east and north, m/s.
fn any_velocity(stream: &mut RandomStream, speed_m_s: Span) -> Vector2<f64> {
    let direction = stream.heading();
    Vector2::new(direction.sin(), direction.cos()) * stream.within(speed_m_s)
}

impl RadarTrack {
    fn measure(&mut self, observation: &TargetObservation<'_>, stream: &mut RandomStream) -> RadarDetection {
        let TargetObservation { radar, antenna, ground, target, time_s } = *observation;
        let true_state = target.path.at(time_s);
        let mut position = true_state.position;
        let mut velocity = true_state.velocity.xy();
        if let Some(walk) = self.seduction {
            let off = walk.velocity * (time_s - walk.from_s);
            position += off.push(0.0);
            velocity += walk.velocity;
        }
        let turn_to = if target.path.turns(time_s) { radar.turn_factor } else { 1.0 };
        self.turning += (turn_to - self.turning) * (1.0 - (-radar.period_s / TURN_S).exp());
        let (range_m, azimuth) = antenna.polar(ground.geodetic(&position));
        let azimuth_deg = azimuth.to_degrees()
            + radar.bias_azimuth_deg
            + self.turning * self.azimuth.at(time_s, stream)
            + stream.normal(radar.plot_azimuth_deg);
        let range_m =
            range_m + radar.bias_range_m + self.range.at(time_s, stream) + stream.normal(radar.plot_range_m);
        let altitude_amsl_m = ground.altitude_amsl_m(&position)
            + radar.bias_height_m
            + self.height.at(time_s, stream)
            + stream.normal(radar.plot_height_m);
        let velocity = match radar.velocity_model {
            VelocityModel::True => velocity,
            VelocityModel::Frozen => self.frozen_velocity,
            VelocityModel::Scaled => velocity * radar.velocity_scale,
        };
        let noise = radar.plot_velocity_m_s;
        let uav_probability = if self.uav_probability == 0.0 {
            0.0
        } else {
            let shown = Span::new(0.0, 1.0);
            (self.uav_probability + stream.normal(radar.plot_probability)).clamp(shown.low, shown.high)
        };
        RadarDetection {
            time_s,
            stamped_s: clock_s(radar, time_s),
            target: 0,
            number: self.number,
            range_m: range_m.max(1.0),
            azimuth_deg: azimuth_deg.rem_euclid(360.0),
            altitude_amsl_m,
            uav_probability,
            velocity: (velocity.x + stream.normal(noise), velocity.y + stream.normal(noise)),
            seduced: self.seduction.is_some(),
        }
    }
}
