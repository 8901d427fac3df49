//! Sections of a scenario. The defaults are those of the error model in `docs/SIMULATION.md`.

use super::keys::{Attack, COUNT, METRES, Pattern, SECONDS, SHARE, VelocityModel, plain_name};
use tables::kinds::Span;
use tables::kinds::{flag, named};
use tables::section;

section! {
    /// The place, and the identity of the service there.
    Place {
        /// WGS-84 latitude of the origin, degrees
        latitude_deg: f64 = 52.5065, -80.0..=80.0;
        /// WGS-84 longitude of the origin, degrees
        longitude_deg: f64 = -0.588, -180.0..=180.0;
        /// Height of the ground above mean sea level, metres
        ground_amsl_m: f64 = 55.0, -400.0..=6000.0;
        /// Height of mean sea level above the WGS-84 ellipsoid, metres
        geoid_undulation_m: f64 = 46.9, -120.0..=100.0;
        /// System area code of the service
        sac: u32 = 25, 0.0..=255.0;
        /// System identification code of the service
        sic: u32 = 1, 0.0..=255.0;
    }
}

section! {
    /// The airspace in which drones fly: a cylinder.
    Airspace {
        /// Centre, metres east of the origin
        east_m: f64 = 1100.0, -50_000.0..=50_000.0;
        /// Centre, metres north of the origin
        north_m: f64 = 1050.0, -50_000.0..=50_000.0;
        /// Radius, metres
        radius_m: f64 = 600.0, 50.0..=50_000.0;
        /// Heights of waypoints above ground, metres
        height_agl_m: Span = Span::new(30.0, 120.0), 0.0..=5000.0;
    }
}

section! {
    /// The drones.
    Drones {
        /// Number of multirotors
        multirotors: u32 = 0, COUNT;
        /// Number of fixed-wing drones
        fixed_wings: u32 = 0, COUNT;
        /// Number of drones with a transponder
        equipped: u32 = 0, COUNT;
        /// Number of transponders that are spoofed
        spoofed: u32 = 0, COUNT;
        /// Number of transponders that are jammed
        jammed: u32 = 0, COUNT;
        /// "free"; "crossing": to and fro through one point; or "formation": together, on a grid
        pattern: Pattern = Pattern::Free, named();
        /// Minimum distance between two drones, metres
        separation_m: f64 = 30.0, METRES;
        /// Pattern "formation": distance between adjacent drones, metres
        formation_m: f64 = 15.0, 2.0..=1000.0;
    }
}

section! {
    /// Flight of multirotors.
    Multirotor {
        /// Cruise speed, metres per second, per drone
        speed_m_s: Span = Span::new(8.0, 16.0), 1.0..=60.0;
        /// Acceleration when speeding up, slowing down and turning, metres per second squared, per drone
        acceleration_m_s2: Span = Span::new(2.0, 4.0), 0.5..=30.0;
        /// Maximum rate of climb and descent, metres per second
        climb_m_s: f64 = 3.0, 0.1..=30.0;
        /// Share of waypoints at which multirotors hover
        hover_share: f64 = 0.5, SHARE;
        /// Duration of a hover, seconds
        hover_s: Span = Span::new(4.0, 15.0), SECONDS;
    }
}

section! {
    /// Flight of fixed-wing drones.
    FixedWing {
        /// Speed, metres per second, per drone
        speed_m_s: Span = Span::new(17.0, 29.0), 5.0..=100.0;
        /// Maximum bank angle, degrees
        bank_deg: f64 = 35.0, 5.0..=80.0;
        /// Maximum rate of climb and descent, metres per second
        climb_m_s: f64 = 3.0, 0.1..=30.0;
        /// Share of waypoints at which fixed wings loiter
        loiter_share: f64 = 0.25, SHARE;
        /// Duration of a loiter, seconds
        loiter_s: Span = Span::new(15.0, 45.0), SECONDS;
    }
}

section! {
    /// Birds.
    Birds {
        /// Number of single birds
        count: u32 = 0, COUNT;
        /// Number of flocks
        flocks: u32 = 0, COUNT;
        /// Number of birds in a flock
        flock_size: u32 = 12, 1.0..=500.0;
        /// Spread of the birds in a flock, one standard deviation per axis, metres
        flock_spread_m: f64 = 15.0, METRES;
        /// Speed, metres per second, per bird
        speed_m_s: Span = Span::new(6.0, 16.0), 0.5..=40.0;
        /// Height above ground, metres
        height_agl_m: Span = Span::new(10.0, 150.0), 0.0..=5000.0;
        /// Share of birds whose UAV probability is always 0
        zero_share: f64 = 0.65, SHARE;
        /// Mean UAV probability of the other birds, per bird
        probability: Span = Span::new(0.05, 0.35), SHARE;
        /// Share of the other birds that look like drones to the radar
        high_share: f64 = 0.05, SHARE;
        /// Mean UAV probability of birds that look like drones
        high_probability: Span = Span::new(0.4, 0.7), SHARE;
    }
}

section! {
    /// Vehicles and clutter.
    Clutter {
        /// Number of vehicles, on straight roads
        vehicles: u32 = 0, COUNT;
        /// Speed of the vehicles, metres per second
        vehicle_speed_m_s: Span = Span::new(8.0, 25.0), 0.5..=60.0;
        /// Number of fixed points on the ground that the radar detects from time to time
        points: u32 = 0, COUNT;
        /// UAV probability of vehicles and fixed points
        probability: Span = Span::new(0.0, 0.2), SHARE;
    }
}

section! {
    /// A radar and its errors.
    Radar {
        /// Name of the radar
        id: String = "gamekeeper".to_owned(), plain_name();
        /// System area code
        sac: u32 = 25, 0.0..=255.0;
        /// System identification code
        sic: u32 = 200, 0.0..=255.0;
        /// Position, metres east of the origin
        east_m: f64 = 0.0, -50_000.0..=50_000.0;
        /// Position, metres north of the origin
        north_m: f64 = 0.0, -50_000.0..=50_000.0;
        /// Height of the antenna above ground, metres
        antenna_agl_m: f64 = 4.0, 0.0..=500.0;
        /// Time between two detections of a target, seconds
        period_s: f64 = 0.25, 0.1..=4.0;
        /// Minimum slant range, metres
        min_range_m: f64 = 120.0, METRES;
        /// Maximum slant range, metres
        max_range_m: f64 = 5000.0, METRES;
        /// Whether the radar measures heights (I048/110)
        heights: bool = true, flag();
        /// Whether the radar reports velocities (I048/200)
        velocities: bool = false, flag();
        /// Reported velocities: "true", "frozen" (drawn once per track, unrelated to the target) or "scaled"
        velocity_model: VelocityModel = VelocityModel::True, named();
        /// Speed of frozen velocities, metres per second, per track
        velocity_frozen_m_s: Span = Span::new(2.0, 25.0), 0.0..=100.0;
        /// Factor of scaled velocities
        velocity_scale: f64 = 0.5, -10.0..=10.0;
        /// Whether the radar sends service messages (CAT034), one per turn, at most one per second
        service_messages: bool = true, flag();
        /// Misalignment: constant bias of azimuths, degrees
        bias_azimuth_deg: f64 = 0.4, -180.0..=180.0;
        /// Misalignment: constant bias of ranges, metres
        bias_range_m: f64 = 4.0, -1000.0..=1000.0;
        /// Misalignment: constant bias of heights, metres
        bias_height_m: f64 = 2.0, -1000.0..=1000.0;
        /// Bias of a track's azimuth, one standard deviation, degrees (Gauss-Markov)
        track_azimuth_deg: f64 = 1.25, 0.0..=45.0;
        /// Bias of a track's range, one standard deviation, metres (Gauss-Markov)
        track_range_m: f64 = 4.0, METRES;
        /// Bias of a track's height, one standard deviation, metres (Gauss-Markov)
        track_height_m: f64 = 8.0, METRES;
        /// Time constant of the track biases, seconds
        track_time_s: f64 = 20.0, 0.1..=1e6;
        /// Factor of the azimuth bias while the target turns
        turn_factor: f64 = 1.7, 0.0..=20.0;
        /// White noise of a plot's azimuth, one standard deviation, degrees
        plot_azimuth_deg: f64 = 0.18, 0.0..=45.0;
        /// White noise of a plot's range, one standard deviation, metres
        plot_range_m: f64 = 2.0, METRES;
        /// White noise of a plot's height, one standard deviation, metres
        plot_height_m: f64 = 2.5, METRES;
        /// White noise of a plot's velocity, one standard deviation per axis, metres per second
        plot_velocity_m_s: f64 = 1.0, 0.0..=100.0;
        /// Mean duration of a period in which a target is visible, seconds (exponential)
        seen_s: f64 = 18.0, 0.1..=1e9;
        /// Mean duration of a period in which a target is invisible, seconds (exponential)
        unseen_s: f64 = 20.0, 0.0..=1e6;
        /// Divisor of seen_s for a target that hovers
        hover_factor: f64 = 2.0, 0.1..=100.0;
        /// Probability of detection of a visible target
        detection: f64 = 0.95, SHARE;
        /// Number of detections that confirm a track; only confirmed tracks are reported
        confirmed_by: u32 = 3, 1.0..=100.0;
        /// Time without a detection after which a track is dropped, seconds
        drop_after_s: f64 = 2.5, SECONDS;
        /// Mean time between two seductions of a track away from its target, seconds; 0: never
        seduction_every_s: f64 = 70.0, SECONDS;
        /// Speed of a seduced track, metres per second
        seduction_m_s: Span = Span::new(5.0, 14.0), 0.0..=100.0;
        /// Duration of a seduction, seconds; the track then ends
        seduction_s: Span = Span::new(4.0, 10.0), SECONDS;
        /// Distance between two drones below which their track numbers may be swapped, metres
        swap_distance_m: f64 = 45.0, METRES;
        /// Probability of a swap in one encounter
        swap_share: f64 = 0.3, SHARE;
        /// First track number
        first_number: u32 = 1, 0.0..=4095.0;
        /// Last track number; numbering then continues with 1
        last_number: u32 = 4095, 1000.0..=4095.0;
        /// Mean UAV probability of drones, per drone
        drone_probability: Span = Span::new(0.5, 0.95), SHARE;
        /// Share of drones that look like birds to the radar
        low_share: f64 = 0.08, SHARE;
        /// Mean UAV probability of drones that look like birds
        low_probability: Span = Span::new(0.02, 0.2), SHARE;
        /// Variation of the mean UAV probability from track to track, one standard deviation
        track_probability: f64 = 0.05, SHARE;
        /// Variation of the UAV probability from plot to plot, one standard deviation
        plot_probability: f64 = 0.05, SHARE;
        /// Time from a plot to its arrival, seconds
        latency_s: Span = Span::new(0.25, 0.6), SECONDS;
        /// Whether the radar detects crewed aircraft
        sees_crewed: bool = false, flag();
        /// Clock error at the start, seconds; positive: the clock is fast
        clock_s: f64 = 0.0, -10.0..=10.0;
        /// Clock drift, milliseconds per second; positive: the clock gains
        clock_drift_ms_s: f64 = 0.0, -10.0..=10.0;
        /// Share of drones that have multipath ghosts
        ghost_share: f64 = 0.0, SHARE;
        /// Mean time between two ghosts of a drone, seconds; 0: never
        ghost_every_s: f64 = 20.0, SECONDS;
        /// Duration of a ghost, seconds
        ghost_s: Span = Span::new(10.0, 40.0), SECONDS;
        /// Distance of a ghost behind its drone, metres
        ghost_m: Span = Span::new(60.0, 200.0), 1.0..=5000.0;
    }
}

section! {
    /// The transponders, their receiver, and their errors.
    Transponder {
        /// Whether there is a receiver
        has_receiver: bool = true, flag();
        /// System area code of the receiver
        sac: u32 = 0, 0.0..=255.0;
        /// System identification code of the receiver
        sic: u32 = 0, 0.0..=255.0;
        /// Time between two reports, seconds, per drone
        period_s: Span = Span::new(2.0, 4.0), 0.1..=60.0;
        /// Variation of the period from report to report, as a share of the period
        jitter: f64 = 0.1, SHARE;
        /// Share of reports that are lost
        dropped: f64 = 0.05, SHARE;
        /// Mean time between two gaps, seconds; 0: never
        gap_every_s: f64 = 90.0, SECONDS;
        /// Duration of a gap, seconds
        gap_s: Span = Span::new(6.0, 20.0), SECONDS;
        /// Time from take-off to the first report, seconds
        starts_after_s: Span = Span::new(0.0, 6.0), SECONDS;
        /// Time from the last report to the end, seconds
        ends_before_s: Span = Span::new(0.0, 6.0), SECONDS;
        /// Bias of the position, one standard deviation per axis, metres (Gauss-Markov)
        gnss_horizontal_m: f64 = 1.8, METRES;
        /// Bias of the height, one standard deviation, metres (Gauss-Markov)
        gnss_vertical_m: f64 = 2.5, METRES;
        /// Time constant of both biases, seconds
        gnss_time_s: f64 = 60.0, 0.1..=1e6;
        /// White noise of a reported position, one standard deviation per axis, metres
        gnss_white_m: f64 = 0.5, METRES;
        /// Mean time between two GNSS jumps, seconds; 0: never
        jump_every_s: f64 = 0.0, SECONDS;
        /// Distance of a GNSS jump, metres
        jump_m: Span = Span::new(20.0, 60.0), METRES;
        /// Duration of a GNSS jump, seconds
        jump_s: Span = Span::new(5.0, 20.0), SECONDS;
        /// Attack on spoofed transponders: "drift", "jump", "frozen", "replay", "duplicate", "swapped" or "time"
        attack: Attack = Attack::Drift, named();
        /// Time from take-off to the beginning of spoofing, seconds
        spoof_after_s: Span = Span::new(60.0, 120.0), SECONDS;
        /// Duration of spoofing, seconds; 0: to the end
        spoof_lasts_s: f64 = 0.0, SECONDS;
        /// Attacks "drift" and "jump": final distance of the false position, metres
        spoof_drift_m: f64 = 100.0, METRES;
        /// Attack "drift": duration of the drift, seconds; the distance then stays constant
        spoof_drift_s: f64 = 60.0, 1.0..=1e6;
        /// Attack "replay": length of the earlier recording that is repeated, seconds
        replay_s: f64 = 60.0, 1.0..=1e6;
        /// Attack "duplicate": distance of the second transmitter, metres
        duplicate_m: f64 = 500.0, METRES;
        /// Attack "time": shift of the time stamps, seconds; positive: later
        time_shift_s: f64 = 2.0, -60.0..=60.0;
        /// Time from take-off to the beginning of jamming, seconds
        jam_after_s: Span = Span::new(60.0, 120.0), SECONDS;
        /// Duration of jamming, during which the transponder is silent, seconds
        jam_s: Span = Span::new(60.0, 120.0), SECONDS;
        /// Time from the measurement of a position to its time stamp, seconds, fixed per drone
        stamped_late_s: Span = Span::new(0.0, 0.25), 0.0..=10.0;
        /// Time from a report's time stamp to its arrival, seconds
        latency_s: Span = Span::new(0.3, 1.5), SECONDS;
        /// Share of reports with an additional delay
        held_up: f64 = 0.01, SHARE;
        /// Additional delay of these reports, seconds
        held_up_s: Span = Span::new(2.0, 5.0), SECONDS;
        /// Whether transponders report velocities (I129/185, I129/220)
        velocities: bool = false, flag();
        /// Share of drones that report their accuracy (I129/110)
        accuracy_share: f64 = 0.5, SHARE;
        /// Accuracy that they report, metres, per drone; [0, 0]: the accuracy that matches their horizontal errors
        stated_m: Span = Span::new(0.0, 0.0), 0.0..=255.0;
        /// Additional time from the measurement of a position to its time stamp, seconds, per report
        stamp_jitter_s: Span = Span::new(0.0, 0.0), 0.0..=10.0;
        /// Step to which latitude and longitude are rounded, degrees; 0: the resolution of CAT129
        rounded_deg: f64 = 0.0, 0.0..=0.01;
        /// Share of drones with barometric heights
        barometric_share: f64 = 0.0, SHARE;
        /// Error of barometric heights, metres, fixed per drone
        barometric_m: Span = Span::new(0.0, 0.0), -1000.0..=1000.0;
        /// Share of drones with a transponder that carry a second one, with a different identity
        second_share: f64 = 0.0, SHARE;
        /// Time between two reports of a second transponder, seconds, per drone
        second_period_s: Span = Span::new(1.0, 2.0), 0.1..=60.0;
        /// Ratio of the position errors of a second transponder to those of a first one
        second_errors: f64 = 2.0, 0.0..=20.0;
    }
}

section! {
    /// The network between sensors and service.
    Network {
        /// Share of datagrams that are lost
        lost: f64 = 0.0, SHARE;
        /// Share of datagrams that arrive twice
        duplicated: f64 = 0.0, SHARE;
        /// Share of datagrams that later datagrams overtake
        reordered: f64 = 0.0, SHARE;
        /// Delay of a duplicate or of an overtaken datagram, seconds
        behind_s: Span = Span::new(0.01, 0.8), SECONDS;
        /// Whether all sensors also send over a second line, to a second port
        second_line: bool = false, flag();
        /// Delay of the second line, seconds
        second_line_behind_s: Span = Span::new(0.0, 0.05), SECONDS;
        /// Rate of datagrams from unknown sources (SAC 99, SIC 98), per second
        foreign_source_per_s: f64 = 0.0, 0.0..=1000.0;
        /// Rate of datagrams of other categories, per second
        foreign_category_per_s: f64 = 0.0, 0.0..=1000.0;
    }
}
