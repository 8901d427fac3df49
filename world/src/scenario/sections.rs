//! The sections. Defaults are those of the error model in `docs/SIMULATION.md`.

use super::keys::{Attack, COUNT, METRES, Pattern, SECONDS, SHARE, VelocityModel, plain_name};
use tables::kinds::Span;
use tables::kinds::{flag, named};
use tables::section;

section! {
    /// The place, and the service that listens there.
    Place {
        /// WGS-84 latitude of the origin, degrees
        latitude_deg: f64 = 52.5065, -80.0..=80.0;
        /// WGS-84 longitude of the origin, degrees
        longitude_deg: f64 = -0.588, -180.0..=180.0;
        /// the ground above mean sea level, metres
        ground_amsl_m: f64 = 55.0, -400.0..=6000.0;
        /// mean sea level above the ellipsoid, metres
        geoid_undulation_m: f64 = 46.9, -120.0..=100.0;
        /// system area code of the service
        sac: u32 = 25, 0.0..=255.0;
        /// system identification code of the service
        sic: u32 = 1, 0.0..=255.0;
    }
}

section! {
    /// Where drones fly: a cylinder.
    Airspace {
        /// its middle, metres east of the origin
        east_m: f64 = 1100.0, -50_000.0..=50_000.0;
        /// its middle, metres north of the origin
        north_m: f64 = 1050.0, -50_000.0..=50_000.0;
        /// its radius, metres
        radius_m: f64 = 600.0, 50.0..=50_000.0;
        /// heights of waypoints above ground, metres
        height_agl_m: Span = Span::new(30.0, 120.0), 0.0..=5000.0;
    }
}

section! {
    /// The drones.
    Drones {
        /// how many multirotors
        multirotors: u32 = 0, COUNT;
        /// how many fixed wings
        fixed_wings: u32 = 0, COUNT;
        /// how many of them carry a transponder
        equipped: u32 = 0, COUNT;
        /// how many transponders are spoofed
        spoofed: u32 = 0, COUNT;
        /// how many transponders are jammed
        jammed: u32 = 0, COUNT;
        /// "free" or "crossing": there and back through one point
        pattern: Pattern = Pattern::Free, named();
        /// two drones are never closer, metres
        separation_m: f64 = 30.0, METRES;
    }
}

section! {
    /// How multirotors fly.
    Multirotor {
        /// cruise, metres per second, per drone
        speed_m_s: Span = Span::new(8.0, 16.0), 1.0..=60.0;
        /// to speed up, slow down and turn, metres per second squared, per drone
        acceleration_m_s2: Span = Span::new(2.0, 4.0), 0.5..=30.0;
        /// climb and descent at most, metres per second
        climb_m_s: f64 = 3.0, 0.1..=30.0;
        /// share of waypoints at which they hover
        hover_share: f64 = 0.5, SHARE;
        /// how long they hover, seconds
        hover_s: Span = Span::new(4.0, 15.0), SECONDS;
    }
}

section! {
    /// How fixed wings fly.
    FixedWing {
        /// speed, metres per second, per drone
        speed_m_s: Span = Span::new(17.0, 29.0), 5.0..=100.0;
        /// steepest bank, degrees
        bank_deg: f64 = 35.0, 5.0..=80.0;
        /// climb and descent at most, metres per second
        climb_m_s: f64 = 3.0, 0.1..=30.0;
        /// share of waypoints at which they loiter
        loiter_share: f64 = 0.25, SHARE;
        /// how long they loiter, seconds
        loiter_s: Span = Span::new(15.0, 45.0), SECONDS;
    }
}

section! {
    /// Birds.
    Birds {
        /// how many alone
        count: u32 = 0, COUNT;
        /// how many flocks
        flocks: u32 = 0, COUNT;
        /// birds of a flock
        flock_size: u32 = 12, 1.0..=500.0;
        /// how far the birds of a flock spread, one standard deviation per axis, metres
        flock_spread_m: f64 = 15.0, METRES;
        /// speed, metres per second, per bird
        speed_m_s: Span = Span::new(6.0, 16.0), 0.5..=40.0;
        /// height above ground, metres
        height_agl_m: Span = Span::new(10.0, 150.0), 0.0..=5000.0;
        /// share of birds whose UAV probability is always 0
        zero_share: f64 = 0.65, SHARE;
        /// mean UAV probability of the others, per bird
        probability: Span = Span::new(0.05, 0.35), SHARE;
        /// share of those others that look like drones
        high_share: f64 = 0.05, SHARE;
        /// mean UAV probability of these
        high_probability: Span = Span::new(0.4, 0.7), SHARE;
    }
}

section! {
    /// What else moves, or does not.
    Clutter {
        /// vehicles on straight roads
        vehicles: u32 = 0, COUNT;
        /// their speed, metres per second
        vehicle_speed_m_s: Span = Span::new(8.0, 25.0), 0.5..=60.0;
        /// places on the ground that the radar sees now and then
        points: u32 = 0, COUNT;
        /// UAV probability of both
        probability: Span = Span::new(0.0, 0.2), SHARE;
    }
}

section! {
    /// A radar and how it fails.
    Radar {
        /// its name
        id: String = "gamekeeper".to_owned(), plain_name();
        /// system area code
        sac: u32 = 25, 0.0..=255.0;
        /// system identification code
        sic: u32 = 200, 0.0..=255.0;
        /// where it stands, metres east of the origin
        east_m: f64 = 0.0, -50_000.0..=50_000.0;
        /// where it stands, metres north of the origin
        north_m: f64 = 0.0, -50_000.0..=50_000.0;
        /// its antenna above ground, metres
        antenna_agl_m: f64 = 4.0, 0.0..=500.0;
        /// from one detection of a target to the next, seconds
        period_s: f64 = 0.25, 0.1..=4.0;
        /// nearest slant range, metres
        min_range_m: f64 = 120.0, METRES;
        /// farthest slant range, metres
        max_range_m: f64 = 5000.0, METRES;
        /// whether it measures heights (I048/110)
        heights: bool = true, flag();
        /// whether it reports velocities (I048/200)
        velocities: bool = false, flag();
        /// "true", "frozen" (drawn once per track, whatever flies) or "scaled": what these velocities are
        velocity_model: VelocityModel = VelocityModel::True, named();
        /// speed of those that are frozen, metres per second, per track
        velocity_frozen_m_s: Span = Span::new(2.0, 25.0), 0.0..=100.0;
        /// factor of those that are scaled
        velocity_scale: f64 = 0.5, -10.0..=10.0;
        /// whether it sends service messages (CAT034), one per turn, at most one per second
        service_messages: bool = true, flag();
        /// misalignment: constant bias of its azimuths, degrees
        bias_azimuth_deg: f64 = 0.4, -180.0..=180.0;
        /// misalignment: constant bias of its ranges, metres
        bias_range_m: f64 = 4.0, -1000.0..=1000.0;
        /// misalignment: constant bias of its heights, metres
        bias_height_m: f64 = 2.0, -1000.0..=1000.0;
        /// bias of a track's azimuth, one standard deviation, degrees (Gauss-Markov)
        track_azimuth_deg: f64 = 1.25, 0.0..=45.0;
        /// bias of a track's range, metres
        track_range_m: f64 = 4.0, METRES;
        /// bias of a track's height, metres
        track_height_m: f64 = 8.0, METRES;
        /// time constant of the biases, seconds
        track_time_s: f64 = 20.0, 0.1..=1e6;
        /// factor of the azimuth bias in turns
        turn_factor: f64 = 1.7, 0.0..=20.0;
        /// white noise of a plot's azimuth, one standard deviation, degrees
        plot_azimuth_deg: f64 = 0.18, 0.0..=45.0;
        /// white noise of a plot's range, metres
        plot_range_m: f64 = 2.0, METRES;
        /// white noise of a plot's height, metres
        plot_height_m: f64 = 2.5, METRES;
        /// white noise of a plot's velocity per axis, metres per second
        plot_velocity_m_s: f64 = 1.0, 0.0..=100.0;
        /// mean time for which a target is seen, seconds (exponential)
        seen_s: f64 = 18.0, 0.1..=1e9;
        /// mean time for which it is then not seen, seconds (exponential)
        unseen_s: f64 = 20.0, 0.0..=1e6;
        /// factor by which that is shorter in hover
        hover_factor: f64 = 2.0, 0.1..=100.0;
        /// probability of detection while seen
        detection: f64 = 0.95, SHARE;
        /// detections that confirm a track, which is then reported
        confirmed_by: u32 = 3, 1.0..=100.0;
        /// time without detection after which a track is dropped, seconds
        drop_after_s: f64 = 2.5, SECONDS;
        /// mean time between two seductions of a track away from its target, seconds; 0: never
        seduction_every_s: f64 = 70.0, SECONDS;
        /// speed of a seduced track, metres per second
        seduction_m_s: Span = Span::new(5.0, 14.0), 0.0..=100.0;
        /// duration of a seduction, seconds; then the track ends
        seduction_s: Span = Span::new(4.0, 10.0), SECONDS;
        /// drones closer than this may have their track numbers swapped, metres
        swap_distance_m: f64 = 45.0, METRES;
        /// how likely that is in one encounter
        swap_share: f64 = 0.3, SHARE;
        /// the first track number
        first_number: u32 = 1, 0.0..=4095.0;
        /// the last track number; then it begins again with number 1
        last_number: u32 = 4095, 1000.0..=4095.0;
        /// mean UAV probability of drones, per drone
        drone_probability: Span = Span::new(0.5, 0.95), SHARE;
        /// share of drones that look like birds
        low_share: f64 = 0.08, SHARE;
        /// mean UAV probability of these
        low_probability: Span = Span::new(0.02, 0.2), SHARE;
        /// how much the mean differs from track to track, one standard deviation
        track_probability: f64 = 0.05, SHARE;
        /// how much the UAV probability differs from plot to plot, one standard deviation
        plot_probability: f64 = 0.05, SHARE;
        /// from a plot to its arrival, seconds
        latency_s: Span = Span::new(0.25, 0.6), SECONDS;
        /// whether it sees crewed aircraft
        sees_crewed: bool = false, flag();
    }
}

section! {
    /// The transponders, their receiver, and how they fail.
    Transponder {
        /// whether there is a receiver
        has_receiver: bool = true, flag();
        /// system area code of the receiver
        sac: u32 = 0, 0.0..=255.0;
        /// system identification code of the receiver
        sic: u32 = 0, 0.0..=255.0;
        /// between two reports, seconds, per drone
        period_s: Span = Span::new(2.0, 4.0), 0.1..=60.0;
        /// how much the period varies from report to report, share of it
        jitter: f64 = 0.1, SHARE;
        /// share of reports that get lost
        dropped: f64 = 0.05, SHARE;
        /// mean time between two gaps, seconds; 0: never
        gap_every_s: f64 = 90.0, SECONDS;
        /// how long a gap lasts, seconds
        gap_s: Span = Span::new(6.0, 20.0), SECONDS;
        /// time from take-off to the first report, seconds
        starts_after_s: Span = Span::new(0.0, 6.0), SECONDS;
        /// time from the last report to the end, seconds
        ends_before_s: Span = Span::new(0.0, 6.0), SECONDS;
        /// bias of the position, one standard deviation per axis, metres (Gauss-Markov)
        gnss_horizontal_m: f64 = 1.8, METRES;
        /// bias of the height, metres
        gnss_vertical_m: f64 = 2.5, METRES;
        /// time constant of the biases, seconds
        gnss_time_s: f64 = 60.0, 0.1..=1e6;
        /// white noise of a report per axis, metres
        gnss_white_m: f64 = 0.5, METRES;
        /// mean time between two GNSS jumps, seconds; 0: never
        jump_every_s: f64 = 0.0, SECONDS;
        /// distance of a jump, metres
        jump_m: Span = Span::new(20.0, 60.0), METRES;
        /// duration of a jump, seconds
        jump_s: Span = Span::new(5.0, 20.0), SECONDS;
        /// what a spoofed transponder does: "drift", "jump", "frozen", "replay", "duplicate", "swapped" or "time"
        attack: Attack = Attack::Drift, named();
        /// time from take-off to the beginning of spoofing, seconds
        spoof_after_s: Span = Span::new(60.0, 120.0), SECONDS;
        /// how long spoofing lasts, seconds; 0: to the end
        spoof_lasts_s: f64 = 0.0, SECONDS;
        /// distance to which the spoofed position drifts, or jumps, metres
        spoof_drift_m: f64 = 100.0, METRES;
        /// duration of the drift, seconds; then the distance stays
        spoof_drift_s: f64 = 60.0, 1.0..=1e6;
        /// attack "replay": the time before it that is sent again and again, seconds
        replay_s: f64 = 60.0, 1.0..=1e6;
        /// attack "duplicate": distance of the second transmitter, metres
        duplicate_m: f64 = 500.0, METRES;
        /// attack "time": how much later time stamps are, seconds; negative: earlier
        time_shift_s: f64 = 2.0, -60.0..=60.0;
        /// time from take-off to the beginning of jamming, seconds
        jam_after_s: Span = Span::new(60.0, 120.0), SECONDS;
        /// how long a jammed transponder is silent, seconds
        jam_s: Span = Span::new(60.0, 120.0), SECONDS;
        /// time from the measurement of a position to its time stamp, seconds, fixed per drone
        stamped_late_s: Span = Span::new(0.0, 0.25), 0.0..=10.0;
        /// from a report's stamp to its arrival, seconds
        latency_s: Span = Span::new(0.3, 1.5), SECONDS;
        /// share of reports that are held up
        held_up: f64 = 0.01, SHARE;
        /// by how much, seconds
        held_up_s: Span = Span::new(2.0, 5.0), SECONDS;
        /// whether they report velocities (I129/185, I129/220)
        velocities: bool = false, flag();
        /// share of drones that report their accuracy (I129/110)
        accuracy_share: f64 = 0.5, SHARE;
    }
}

section! {
    /// The network between sensors and service.
    Network {
        /// share of datagrams that get lost
        lost: f64 = 0.0, SHARE;
        /// share of datagrams that come twice
        duplicated: f64 = 0.0, SHARE;
        /// share of datagrams that are overtaken
        reordered: f64 = 0.0, SHARE;
        /// how far a copy or an overtaken datagram is behind, seconds
        behind_s: Span = Span::new(0.01, 0.8), SECONDS;
        /// whether everything comes over a second line as well, one port further
        second_line: bool = false, flag();
        /// how far the second line is behind, seconds
        second_line_behind_s: Span = Span::new(0.0, 0.05), SECONDS;
        /// datagrams of sources that no sensor has (SAC 99, SIC 98), per second
        foreign_source_per_s: f64 = 0.0, 0.0..=1000.0;
        /// datagrams of other categories, per second
        foreign_category_per_s: f64 = 0.0, 0.0..=1000.0;
    }
}
