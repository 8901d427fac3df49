//! Status of the sensor: I063/060.

use crate::item::items;

items! {
    /// CON in I063/060: state of the connection.
    all pub enum Connection {
        /// 0: operational.
        Operational,
        /// 1: degraded.
        Degraded,
        /// 2: initialising.
        Initialising,
        /// 3: not connected.
        NotConnected,
    }

    /// I063/060, sensor configuration and status: one octet and, where sent, its extensions. Values of an absent extension are
    /// `false`, or `None` if a bit states whether they are populated.
    extended pub struct SensorStatus {
        first {
            /// CON, state of the connection.
            code 2 "con" connection / with_connection: Connection;
            /// PSR: PSR data must not be used.
            flag 1 "psr" is_psr_nogo / with_psr_nogo;
            /// SSR: SSR data must not be used.
            flag 1 "ssr" is_ssr_nogo / with_ssr_nogo;
            /// MDS: Mode S data must not be used.
            flag 1 "mds" is_mode_s_nogo / with_mode_s_nogo;
            /// ADS: ADS-B data must not be used.
            flag 1 "ads" is_adsb_nogo / with_adsb_nogo;
            /// MLT: multilateration data must not be used.
            flag 1 "mlt" is_multilateration_nogo / with_multilateration_nogo;
        }
        extension {
            /// OPS: operational use is inhibited.
            flag 1 "ops" is_inhibited / with_inhibited;
            /// ODP: the data processor is overloaded.
            flag 1 "odp" is_processor_overloaded / with_processor_overloaded;
            /// OXT: the transmission subsystem is overloaded.
            flag 1 "oxt" is_transmission_overloaded / with_transmission_overloaded;
            /// MSC: the monitoring system is disconnected.
            flag 1 "msc" is_monitor_disconnected / with_monitor_disconnected;
            /// TSV: the time source is invalid.
            flag 1 "tsv" is_time_invalid / with_time_invalid;
            /// NPW: no plots are received.
            flag 1 "npw" has_no_plots / with_no_plots;
            spare 1 "spare_2";
        }
        extension {
            count 1 "ttf_ep";
            /// TTF: the test target failed; from edition 1.7 on.
            populated_flag 1 "ttf" is_test_target_failed;
            count 1 "spo_ep";
            /// SPO: possibly spoofed; from edition 1.7 on.
            populated_flag 1 "spo" is_spoofed;
            spare 3 "spare_3";
        }
    }
}
