//! The sections of what broadcasts beside CAT129: crewed aircraft with ADS-B, drones with Remote ID; and of cameras.

use super::keys::{COUNT, METRES, SECONDS, SHARE, plain_name};
use tables::kinds::Span;
use tables::kinds::flag;
use tables::section;

section! {
    /// Crewed aircraft, and surface vehicles of an aerodrome; all have ADS-B.
    Crewed {
        /// aeroplanes that fly to and fro over the place
        transits: u32 = 0, COUNT;
        /// aeroplanes in the aerodrome's circuit
        circuits: u32 = 0, COUNT;
        /// helicopters, lower and nearer
        helicopters: u32 = 0, COUNT;
        /// helicopters that meet a drone, straight
        conflicts: u32 = 0, COUNT;
        /// surface vehicles on the aerodrome
        vehicles: u32 = 0, COUNT;
        /// speed, metres per second, per aircraft
        speed_m_s: Span = Span::new(60.0, 120.0), 20.0..=350.0;
        /// the same of helicopters
        helicopter_speed_m_s: Span = Span::new(60.0, 80.0), 20.0..=120.0;
        /// the same in the circuit
        circuit_speed_m_s: Span = Span::new(60.0, 70.0), 20.0..=120.0;
        /// heights of waypoints above ground, metres
        height_agl_m: Span = Span::new(150.0, 600.0), 0.0..=12_000.0;
        /// climb and descent at most, metres per second
        climb_m_s: f64 = 5.0, 0.1..=30.0;
        /// rate of a standard turn, degrees per second
        turn_deg_s: f64 = 3.0, 0.5..=20.0;
        /// how far from the middle of the airspace they turn back, metres
        radius_m: f64 = 6000.0, 500.0..=100_000.0;
        /// how near a conflict comes to its drone, metres, level with it
        miss_m: Span = Span::new(0.0, 40.0), METRES;
        /// when, as a share of the duration
        meets_at: Span = Span::new(0.4, 0.6), SHARE;
        /// the aerodrome's middle, metres east of the origin
        aerodrome_east_m: f64 = 1100.0, -50_000.0..=50_000.0;
        /// the same north
        aerodrome_north_m: f64 = -1500.0, -50_000.0..=50_000.0;
        /// direction of the runway, degrees
        runway_deg: f64 = 70.0, 0.0..=360.0;
        /// length of the circuit along the runway, metres
        circuit_length_m: f64 = 5000.0, METRES;
        /// its width, metres
        circuit_width_m: f64 = 3000.0, METRES;
        /// its height above ground, metres
        circuit_agl_m: f64 = 300.0, 30.0..=2000.0;
    }
}

section! {
    /// The ADS-B receiver (CAT021 edition 2.6), and how ADS-B fails.
    Adsb {
        /// its name
        id: String = "adsb".to_owned(), plain_name();
        /// system area code
        sac: u32 = 25, 0.0..=255.0;
        /// system identification code
        sic: u32 = 210, 0.0..=255.0;
        /// where it stands, metres east of the origin
        east_m: f64 = 0.0, -50_000.0..=50_000.0;
        /// where it stands, metres north of the origin
        north_m: f64 = 0.0, -50_000.0..=50_000.0;
        /// how far it hears, metres
        range_m: f64 = 80_000.0, 100.0..=500_000.0;
        /// between two records of an aircraft, seconds
        period_s: Span = Span::new(0.9, 1.1), 0.1..=60.0;
        /// share of records that get lost
        lost: f64 = 0.05, SHARE;
        /// mean time between two gaps, seconds; 0: never
        gap_every_s: f64 = 120.0, SECONDS;
        /// how long a gap lasts, seconds
        gap_s: Span = Span::new(3.0, 10.0), SECONDS;
        /// bias of the position, one standard deviation per axis, metres (Gauss-Markov)
        gnss_horizontal_m: f64 = 3.0, METRES;
        /// bias of the geometric height, metres
        gnss_vertical_m: f64 = 5.0, METRES;
        /// time constant of both, seconds
        gnss_time_s: f64 = 60.0, 0.1..=1e6;
        /// error of the pressure altitude, one standard deviation, metres, fixed per aircraft
        barometric_m: f64 = 38.0, METRES;
        /// pressure altitude less height above mean sea level: the weather, metres
        weather_m: Span = Span::new(-150.0, 150.0), -1000.0..=1000.0;
        /// share of aircraft that state no accuracy (NACp 0)
        nacp_missing: f64 = 0.2, SHARE;
        /// NACp of the others, whole numbers, per aircraft
        nacp: Span = Span::new(8.0, 10.0), 1.0..=11.0;
        /// share of aircraft without a geometric height (I021/140)
        barometric_share: f64 = 0.15, SHARE;
        /// share of aircraft whose records have a time of applicability (I021/071); the others have that of reception only
        applicability_share: f64 = 0.15, SHARE;
        /// share of aircraft without an emitter category (I021/020)
        no_category_share: f64 = 0.05, SHARE;
        /// from the measurement of a position to its time of reception, which stamps it, seconds, per aircraft
        stamped_late_s: Span = Span::new(0.0, 0.3), 0.0..=10.0;
        /// from a record's stamp to its arrival, seconds
        latency_s: Span = Span::new(0.1, 0.8), SECONDS;
    }
}

section! {
    /// Remote ID of drones, its receiver, and fakes.
    RemoteId {
        /// the receiver's name
        id: String = "remote-id".to_owned(), plain_name();
        /// system area code
        sac: u32 = 25, 0.0..=255.0;
        /// system identification code
        sic: u32 = 220, 0.0..=255.0;
        /// where it stands, metres east of the origin
        east_m: f64 = 1100.0, -50_000.0..=50_000.0;
        /// where it stands, metres north of the origin
        north_m: f64 = 1050.0, -50_000.0..=50_000.0;
        /// how many drones broadcast
        drones: u32 = 0, COUNT;
        /// whether those without a CAT129 transponder come first; if not, it is drawn by lot
        unequipped_first: bool = false, flag();
        /// whether one with a CAT129 transponder sends that one's serial number; if not, one of its own
        same_serial: bool = true, flag();
        /// frames per second, per drone
        rate_hz: Span = Span::new(4.0, 9.0), 0.1..=50.0;
        /// between two new positions, seconds
        period_s: f64 = 1.0, 0.1..=60.0;
        /// share of drones that send packs of messages
        pack_share: f64 = 0.3, SHARE;
        /// distance at which half of the frames get lost, metres
        range_m: f64 = 1200.0, 10.0..=50_000.0;
        /// slow fading, one standard deviation, decibels
        fading_db: f64 = 6.0, 0.0..=40.0;
        /// its time constant, seconds: losses come in bursts
        fading_s: f64 = 2.0, 0.1..=1e6;
        /// bias of the position, one standard deviation per axis, metres (Gauss-Markov)
        gnss_horizontal_m: f64 = 1.8, METRES;
        /// bias of the height, metres
        gnss_vertical_m: f64 = 2.5, METRES;
        /// time constant of both, seconds
        gnss_time_s: f64 = 60.0, 0.1..=1e6;
        /// white noise of a position per axis, metres
        gnss_white_m: f64 = 0.5, METRES;
        /// share of drones that do not say their altitude
        altitude_unknown: f64 = 0.3, SHARE;
        /// share of drones that do not say their accuracies
        accuracy_unknown: f64 = 0.4, SHARE;
        /// share of drones that do not know their place at first
        lost_share: f64 = 0.1, SHARE;
        /// for how long, seconds
        lost_s: Span = Span::new(5.0, 20.0), SECONDS;
        /// from the measurement of a position to its time stamp, seconds, per drone
        stamped_late_s: Span = Span::new(0.0, 0.3), 0.0..=10.0;
        /// from a frame to its arrival, seconds; those of one transmitter keep their order
        latency_s: Span = Span::new(0.05, 0.4), SECONDS;
        /// identities that a person on the ground sends, of drones that do not exist
        fakes: u32 = 0, COUNT;
        /// where that person stands, metres east of the origin
        fakes_east_m: f64 = 900.0, -50_000.0..=50_000.0;
        /// the same north
        fakes_north_m: f64 = 900.0, -50_000.0..=50_000.0;
        /// how far around they seem to fly, metres
        fakes_radius_m: f64 = 400.0, 50.0..=50_000.0;
        /// frames per second of each
        fakes_rate_hz: f64 = 2.0, 0.1..=50.0;
        /// time from the start to the first of them, seconds
        fakes_after_s: Span = Span::new(40.0, 60.0), SECONDS;
        /// how long they are sent, seconds; 0: to the end
        fakes_last_s: f64 = 0.0, SECONDS;
    }
}

section! {
    /// An EO/IR head: bearings (CAT015 edition 1.2).
    Camera {
        /// its name
        id: String = "camera".to_owned(), plain_name();
        /// system area code
        sac: u32 = 25, 0.0..=255.0;
        /// system identification code
        sic: u32 = 230, 0.0..=255.0;
        /// where it stands, metres east of the origin
        east_m: f64 = 600.0, -50_000.0..=50_000.0;
        /// where it stands, metres north of the origin
        north_m: f64 = 400.0, -50_000.0..=50_000.0;
        /// its lens above ground, metres
        lens_agl_m: f64 = 6.0, 0.0..=500.0;
        /// between two pictures, seconds
        period_s: f64 = 0.3, 0.05..=10.0;
        /// how far it sees drones, metres
        range_m: f64 = 1500.0, METRES;
        /// the same of birds
        bird_range_m: f64 = 400.0, METRES;
        /// the same of crewed aircraft
        crewed_range_m: f64 = 5000.0, METRES;
        /// where the middle of its field of regard lies, degrees
        looks_deg: f64 = 30.0, 0.0..=360.0;
        /// width of its field of regard, degrees
        field_deg: f64 = 180.0, 1.0..=360.0;
        /// elevations of its field of regard, degrees
        elevation_deg: Span = Span::new(-2.0, 60.0), -90.0..=90.0;
        /// misalignment: constant bias of its azimuths, degrees
        bias_azimuth_deg: f64 = 0.2, -180.0..=180.0;
        /// misalignment: constant bias of its elevations, degrees
        bias_elevation_deg: f64 = -0.1, -45.0..=45.0;
        /// white noise of azimuths, one standard deviation, degrees
        noise_azimuth_deg: f64 = 0.1, 0.0..=45.0;
        /// white noise of elevations, degrees
        noise_elevation_deg: f64 = 0.18, 0.0..=45.0;
        /// mean time for which a target is seen, seconds (exponential)
        seen_s: f64 = 25.0, 0.1..=1e9;
        /// mean time for which it is then not seen, seconds (exponential)
        unseen_s: f64 = 10.0, 0.0..=1e6;
        /// probability of detection while seen
        detection: f64 = 0.8, SHARE;
        /// detections that confirm a track, which is then reported
        confirmed_by: u32 = 3, 1.0..=100.0;
        /// time without detection after which a track ends, seconds
        drop_after_s: f64 = 2.0, SECONDS;
        /// from a picture to its arrival, seconds
        latency_s: Span = Span::new(0.1, 0.3), SECONDS;
    }
}
