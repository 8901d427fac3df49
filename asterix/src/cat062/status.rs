//! Status of the track: I062/080.

use crate::item::items;

items! {
    /// SRC in I062/080: source of I062/130.
    all pub enum HeightSource {
        /// 0: no source.
        None,
        /// 1: GNSS.
        Gnss,
        /// 2: 3D radar.
        Radar3D,
        /// 3: triangulation.
        Triangulation,
        /// 4: height from coverage.
        Coverage,
        /// 5: speed look-up table.
        SpeedTable,
        /// 6: default height.
        Default,
        /// 7: multilateration.
        Multilateration,
    }

    /// I062/080, track status: one octet and, where sent, its extensions (6 in edition 1.21; more are kept). Values of an absent
    /// extension are `false` or 0.
    extended pub struct TrackStatus {
        first {
            /// MON: a single sensor.
            flag 1 "mon" is_monosensor / with_monosensor;
            /// SPI: special position identification.
            flag 1 "spi" is_special_position / with_special_position;
            /// MRH: the geometric altitude is the more reliable one; not set: the barometric altitude.
            flag 1 "mrh" is_geometric_reliable / with_geometric_reliable;
            /// SRC, source of I062/130.
            code 3 "src" height_source / with_height_source: HeightSource;
            /// CNF: tentative, not confirmed.
            flag 1 "cnf" is_tentative / with_tentative;
        }
        extension {
            /// SIM: a simulated track.
            flag 1 "sim" is_simulated / with_simulated;
            /// TSE: the last message of this track.
            flag 1 "tse" is_last / with_last;
            /// TSB: the first message of this track.
            flag 1 "tsb" is_first / with_first;
            /// FPC: correlated with a flight plan.
            flag 1 "fpc" has_flight_plan / with_flight_plan;
            /// AFF: ADS-B disagrees with other surveillance.
            flag 1 "aff" is_adsb_inconsistent / with_adsb_inconsistent;
            /// STP: a slave track was promoted.
            flag 1 "stp" is_promoted / with_promoted;
            /// KOS: from the background service; not set: from the complementary service.
            flag 1 "kos" is_background / with_background;
        }
        extension {
            /// AMA: combined from several tracks.
            flag 1 "ama" is_amalgamated / with_amalgamated;
            /// MD4, Mode 4: 0 not interrogated, 1 friendly, 2 unknown, 3 no reply.
            count 2 "md4" mode_4 / with_mode_4: u8;
            /// ME: military emergency.
            flag 1 "me" is_military_emergency / with_military_emergency;
            /// MI: military identification.
            flag 1 "mi" is_military_identification / with_military_identification;
            /// MD5, Mode 5: 0 not interrogated, 1 friendly, 2 unknown, 3 no reply.
            count 2 "md5" mode_5 / with_mode_5: u8;
        }
        extension {
            /// CST: coasted, no update for longer than the system's limit.
            flag 1 "cst" is_coasted / with_coasted;
            /// PSR: no primary update for longer than the system's limit.
            flag 1 "psr" lacks_primary / with_primary_lacking;
            /// SSR: no secondary update for longer than the system's limit.
            flag 1 "ssr" lacks_secondary / with_secondary_lacking;
            /// MDS: no Mode S update for longer than the system's limit.
            flag 1 "mds" lacks_mode_s / with_mode_s_lacking;
            /// ADS: no ADS-B update for longer than the system's limit.
            flag 1 "ads" lacks_adsb / with_adsb_lacking;
            /// SUC: a code of special interest.
            flag 1 "suc" has_special_code / with_special_code;
            /// AAC: another track has the same assigned code.
            flag 1 "aac" has_code_conflict / with_code_conflict;
        }
        extension {
            /// SDS, kind of surveillance: 0 combined, 1 co-operative only, 2 non-co-operative only.
            count 2 "sds" surveillance / with_surveillance: u8;
            /// EMS, emergency: 0 none, 1 general, 2 medical, 3 minimum fuel, 4 no communications, 5 unlawful interference,
            /// 6 downed, 7 undefined.
            count 3 "ems" emergency / with_emergency: u8;
            /// PFT: possibly a false track.
            flag 1 "pft" is_possibly_false / with_possibly_false;
            /// FPLT: created or updated with flight plan data.
            flag 1 "fplt" is_of_flight_plan / with_of_flight_plan;
        }
        extension {
            /// DUPT: another track has the same Mode 3/A code.
            flag 1 "dupt" has_duplicate_code / with_duplicate_code;
            /// DUPF: another track has the same flight plan.
            flag 1 "dupf" has_duplicate_plan / with_duplicate_plan;
            /// DUPM: another track has the same flight plan by manual correlation.
            flag 1 "dupm" has_manual_duplicate / with_manual_duplicate;
            /// SFC: on the surface; from edition 1.18 on.
            flag 1 "sfc" is_on_surface / with_on_surface;
            /// IDD: another track has the same flight identification; from edition 1.18 on.
            flag 1 "idd" has_duplicate_identification / with_duplicate_identification;
            /// IEC: inconsistent emergency code; from edition 1.18 on.
            flag 1 "iec" is_emergency_inconsistent / with_emergency_inconsistent;
            /// MLAT: no multilateration update for longer than the system's limit; from edition 1.20 on.
            flag 1 "mlat" lacks_multilateration / with_multilateration_lacking;
        }
        extension {
            /// M5I: no Mode 5 update for longer than the system's limit; from edition 1.21 on.
            flag 1 "m5i" lacks_mode_5 / with_mode_5_lacking;
            spare 6 "spare_7";
        }
    }
}
