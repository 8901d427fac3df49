//! Sections of a scenario for crewed aircraft and ADS-B, Remote ID, and cameras.

use super::keys::{COUNT, METRES, SECONDS, SHARE, plain_name};
use tables::kinds::Span;
use tables::kinds::flag;
use tables::section;

section! {
    /// Crewed aircraft, and surface vehicles of an aerodrome; all have ADS-B.
    Crewed {
        /// Number of aeroplanes that fly to and fro over the place
        transits: u32 = 0, COUNT;
        /// Number of aeroplanes in the aerodrome's circuit
        circuits: u32 = 0, COUNT;
        /// Number of helicopters, which fly lower and nearer
        helicopters: u32 = 0, COUNT;
        /// Number of helicopters that fly straight into an encounter with a drone
        conflicts: u32 = 0, COUNT;
        /// Number of surface vehicles on the aerodrome
        vehicles: u32 = 0, COUNT;
        /// Speed of transits, metres per second, per aircraft
        speed_m_s: Span = Span::new(60.0, 120.0), 20.0..=350.0;
        /// Speed of helicopters, metres per second, per aircraft
        helicopter_speed_m_s: Span = Span::new(60.0, 80.0), 20.0..=120.0;
        /// Speed in the circuit, metres per second, per aircraft
        circuit_speed_m_s: Span = Span::new(60.0, 70.0), 20.0..=120.0;
        /// Heights of waypoints above ground, metres
        height_agl_m: Span = Span::new(150.0, 600.0), 0.0..=12_000.0;
        /// Maximum rate of climb and descent, metres per second
        climb_m_s: f64 = 5.0, 0.1..=30.0;
        /// Rate of a standard turn, degrees per second
        turn_deg_s: f64 = 3.0, 0.5..=20.0;
        /// Distance from the centre of the airspace at which aircraft turn back, metres
        radius_m: f64 = 6000.0, 500.0..=100_000.0;
        /// Horizontal miss distance of a conflict, at the height of the drone, metres
        miss_m: Span = Span::new(0.0, 40.0), METRES;
        /// Time of a conflict, as a share of the duration
        meets_at: Span = Span::new(0.4, 0.6), SHARE;
        /// Centre of the aerodrome, metres east of the origin
        aerodrome_east_m: f64 = 1100.0, -50_000.0..=50_000.0;
        /// Centre of the aerodrome, metres north of the origin
        aerodrome_north_m: f64 = -1500.0, -50_000.0..=50_000.0;
        /// Direction of the runway, degrees
        runway_deg: f64 = 70.0, 0.0..=360.0;
        /// Length of the circuit along the runway, metres
        circuit_length_m: f64 = 5000.0, METRES;
        /// Width of the circuit, metres
        circuit_width_m: f64 = 3000.0, METRES;
        /// Height of the circuit above ground, metres
        circuit_agl_m: f64 = 300.0, 30.0..=2000.0;
    }
}

section! {
    /// The ADS-B receiver (CAT021 edition 2.6), and the errors of ADS-B.
    Adsb {
        /// Name of the receiver
        id: String = "adsb".to_owned(), plain_name();
        /// System area code
        sac: u32 = 25, 0.0..=255.0;
        /// System identification code
        sic: u32 = 210, 0.0..=255.0;
        /// Position, metres east of the origin
        east_m: f64 = 0.0, -50_000.0..=50_000.0;
        /// Position, metres north of the origin
        north_m: f64 = 0.0, -50_000.0..=50_000.0;
        /// Range of the receiver, metres
        range_m: f64 = 80_000.0, 100.0..=500_000.0;
        /// Time between two records of an aircraft, seconds
        period_s: Span = Span::new(0.9, 1.1), 0.1..=60.0;
        /// Share of records that are lost
        lost: f64 = 0.05, SHARE;
        /// Mean time between two gaps, seconds; 0: never
        gap_every_s: f64 = 120.0, SECONDS;
        /// Duration of a gap, seconds
        gap_s: Span = Span::new(3.0, 10.0), SECONDS;
        /// Bias of the position, one standard deviation per axis, metres (Gauss-Markov)
        gnss_horizontal_m: f64 = 3.0, METRES;
        /// Bias of the geometric height, one standard deviation, metres (Gauss-Markov)
        gnss_vertical_m: f64 = 5.0, METRES;
        /// Time constant of both biases, seconds
        gnss_time_s: f64 = 60.0, 0.1..=1e6;
        /// Error of the pressure altitude, one standard deviation, metres, fixed per aircraft
        barometric_m: f64 = 38.0, METRES;
        /// Pressure altitude minus height above mean sea level, due to the weather, metres
        weather_m: Span = Span::new(-150.0, 150.0), -1000.0..=1000.0;
        /// Share of aircraft that report no accuracy (NACp 0)
        nacp_missing: f64 = 0.2, SHARE;
        /// NACp of the other aircraft, whole numbers, per aircraft
        nacp: Span = Span::new(8.0, 10.0), 1.0..=11.0;
        /// Share of aircraft without a geometric height (I021/140)
        barometric_share: f64 = 0.15, SHARE;
        /// Share of aircraft with a time of applicability (I021/071); the others have a time of reception only
        applicability_share: f64 = 0.15, SHARE;
        /// Share of aircraft without an emitter category (I021/020)
        no_category_share: f64 = 0.05, SHARE;
        /// Time from the measurement of a position to its time stamp, the time of reception, seconds, per aircraft
        stamped_late_s: Span = Span::new(0.0, 0.3), 0.0..=10.0;
        /// Time from a record's time stamp to its arrival, seconds
        latency_s: Span = Span::new(0.1, 0.8), SECONDS;
    }
}

section! {
    /// Remote ID of drones, its receiver, and fakes.
    RemoteId {
        /// Name of the receiver
        id: String = "remote-id".to_owned(), plain_name();
        /// System area code
        sac: u32 = 25, 0.0..=255.0;
        /// System identification code
        sic: u32 = 220, 0.0..=255.0;
        /// Position, metres east of the origin
        east_m: f64 = 1100.0, -50_000.0..=50_000.0;
        /// Position, metres north of the origin
        north_m: f64 = 1050.0, -50_000.0..=50_000.0;
        /// Number of drones that broadcast
        drones: u32 = 0, COUNT;
        /// Whether drones without a CAT129 transponder are chosen first; otherwise drones are chosen at random
        unequipped_first: bool = false, flag();
        /// Whether a drone with a CAT129 transponder broadcasts the same serial number; otherwise a different one
        same_serial: bool = true, flag();
        /// Frames per second, per drone
        rate_hz: Span = Span::new(4.0, 9.0), 0.1..=50.0;
        /// Time between two new positions, seconds
        period_s: f64 = 1.0, 0.1..=60.0;
        /// Share of drones that send message packs
        pack_share: f64 = 0.3, SHARE;
        /// Distance at which half of the frames are lost, metres
        range_m: f64 = 1200.0, 10.0..=50_000.0;
        /// Slow fading, one standard deviation, decibels
        fading_db: f64 = 6.0, 0.0..=40.0;
        /// Time constant of fading, seconds; it makes losses come in bursts
        fading_s: f64 = 2.0, 0.1..=1e6;
        /// Bias of the position, one standard deviation per axis, metres (Gauss-Markov)
        gnss_horizontal_m: f64 = 1.8, METRES;
        /// Bias of the height, one standard deviation, metres (Gauss-Markov)
        gnss_vertical_m: f64 = 2.5, METRES;
        /// Time constant of both biases, seconds
        gnss_time_s: f64 = 60.0, 0.1..=1e6;
        /// White noise of a position, one standard deviation per axis, metres
        gnss_white_m: f64 = 0.5, METRES;
        /// Share of drones that do not report their altitude
        altitude_unknown: f64 = 0.3, SHARE;
        /// Share of drones that do not report their accuracies
        accuracy_unknown: f64 = 0.4, SHARE;
        /// Share of drones without a position at first
        lost_share: f64 = 0.1, SHARE;
        /// Duration of the time without a position, seconds
        lost_s: Span = Span::new(5.0, 20.0), SECONDS;
        /// Time from the measurement of a position to its time stamp, seconds, per drone
        stamped_late_s: Span = Span::new(0.0, 0.3), 0.0..=10.0;
        /// Time from a frame to its arrival, seconds; frames of one transmitter keep their order
        latency_s: Span = Span::new(0.05, 0.4), SECONDS;
        /// Number of fake identities, of drones that do not exist, sent by a person on the ground
        fakes: u32 = 0, COUNT;
        /// Position of that person, metres east of the origin
        fakes_east_m: f64 = 900.0, -50_000.0..=50_000.0;
        /// Position of that person, metres north of the origin
        fakes_north_m: f64 = 900.0, -50_000.0..=50_000.0;
        /// Radius within which the fake drones seem to fly, metres
        fakes_radius_m: f64 = 400.0, 50.0..=50_000.0;
        /// Frames per second, per fake
        fakes_rate_hz: f64 = 2.0, 0.1..=50.0;
        /// Time from the start to the first frame of a fake, seconds
        fakes_after_s: Span = Span::new(40.0, 60.0), SECONDS;
        /// Duration of the fakes, seconds; 0: to the end
        fakes_last_s: f64 = 0.0, SECONDS;
    }
}

section! {
    /// An EO/IR camera, which reports bearings (CAT015 edition 1.2).
    Camera {
        /// Name of the camera
        id: String = "camera".to_owned(), plain_name();
        /// System area code
        sac: u32 = 25, 0.0..=255.0;
        /// System identification code
        sic: u32 = 230, 0.0..=255.0;
        /// Position, metres east of the origin
        east_m: f64 = 600.0, -50_000.0..=50_000.0;
        /// Position, metres north of the origin
        north_m: f64 = 400.0, -50_000.0..=50_000.0;
        /// Height of the lens above ground, metres
        lens_agl_m: f64 = 6.0, 0.0..=500.0;
        /// Time between two pictures, seconds
        period_s: f64 = 0.3, 0.05..=10.0;
        /// Range at which the camera detects drones, metres
        range_m: f64 = 1500.0, METRES;
        /// Range at which the camera detects birds, metres
        bird_range_m: f64 = 400.0, METRES;
        /// Range at which the camera detects crewed aircraft, metres
        crewed_range_m: f64 = 5000.0, METRES;
        /// Azimuth of the centre of the field of regard, degrees
        looks_deg: f64 = 30.0, 0.0..=360.0;
        /// Width of the field of regard, degrees
        field_deg: f64 = 180.0, 1.0..=360.0;
        /// Elevations of the field of regard, degrees
        elevation_deg: Span = Span::new(-2.0, 60.0), -90.0..=90.0;
        /// Misalignment: constant bias of azimuths, degrees
        bias_azimuth_deg: f64 = 0.2, -180.0..=180.0;
        /// Misalignment: constant bias of elevations, degrees
        bias_elevation_deg: f64 = -0.1, -45.0..=45.0;
        /// White noise of azimuths, one standard deviation, degrees
        noise_azimuth_deg: f64 = 0.1, 0.0..=45.0;
        /// White noise of elevations, one standard deviation, degrees
        noise_elevation_deg: f64 = 0.18, 0.0..=45.0;
        /// Mean duration of a period in which a target is visible, seconds (exponential)
        seen_s: f64 = 25.0, 0.1..=1e9;
        /// Mean duration of a period in which a target is invisible, seconds (exponential)
        unseen_s: f64 = 10.0, 0.0..=1e6;
        /// Probability of detection of a visible target
        detection: f64 = 0.8, SHARE;
        /// Number of detections that confirm a track; only confirmed tracks are reported
        confirmed_by: u32 = 3, 1.0..=100.0;
        /// Time without a detection after which a track ends, seconds
        drop_after_s: f64 = 2.0, SECONDS;
        /// Time from a picture to its arrival, seconds
        latency_s: Span = Span::new(0.1, 0.3), SECONDS;
    }
}
