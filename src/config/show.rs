//! The effective configuration as TOML.

use std::fmt::{self, Display, Formatter};
use std::num::NonZeroU32;

use jiff::SignedDuration;

use super::Config;
use super::http::{Auth, Http, RateLimit, Tiles, TlsFiles};
use super::tree::quoted;
use super::types::{
    Address, AreaKind, Classification, Fusion, Input, Output, Radar, Sensor, SensorKind, SerialSource, Sink,
    Site, Transponder,
};

/// TOML that reads back to the same value. What is absent and has no default is a comment that says what that means.
impl Display for Config {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        site(f, &self.site)?;
        for entry in &self.sensors {
            sensor(f, entry)?;
        }
        fusion(f, &self.fusion)?;
        for area in &self.areas {
            writeln!(f, "\n[[areas]]")?;
            let (kind, sensor) = match &area.kind {
                AreaKind::Mask => ("mask", None),
                AreaKind::Coverage { sensor } => ("coverage", Some(sensor)),
                AreaKind::Alert => ("alert", None),
            };
            writeln!(f, "kind = \"{kind}\"")?;
            writeln!(f, "file = {}", quoted(&area.file.to_string_lossy()))?;
            if let Some(sensor) = sensor {
                writeln!(f, "sensor = \"{sensor}\"")?;
            }
        }
        output(f, &self.output)?;
        http(f, &self.http)?;
        let state = &self.state;
        writeln!(f, "\n[state]\ndir = {}", quoted(&state.dir.to_string_lossy()))?;
        writeln!(f, "history_hours = {:?}\nhistory_mib = {}", state.history_hours, state.history_mib)
    }
}

fn site(f: &mut Formatter<'_>, site: &Site) -> fmt::Result {
    writeln!(f, "[site]\nname = {}\nsac = {}\nsic = {}", quoted(&site.name), site.sac, site.sic)?;
    optional(f, "geoid_undulation_m", site.geoid_undulation_m, "EGM96 at the first radar")
}

fn sensor(f: &mut Formatter<'_>, sensor: &Sensor) -> fmt::Result {
    let kind = match sensor.kind {
        SensorKind::Radar(_) => "radar",
        SensorKind::Transponder(_) => "transponder",
    };
    writeln!(f, "\n[[sensors]]\nid = \"{}\"\nkind = \"{kind}\"", sensor.id)?;
    writeln!(f, "sac = {}\nsic = {}", sensor.sac, sensor.sic)?;
    let absent = match sensor.kind {
        SensorKind::Radar(_) => "not stated, 0.25 is assumed",
        SensorKind::Transponder(_) => "not stated",
    };
    optional(f, "period_s", sensor.period_s, absent)?;
    match &sensor.kind {
        SensorKind::Radar(radar) => show_radar(f, radar)?,
        SensorKind::Transponder(Transponder { accuracy: Some(accuracy), .. }) => {
            let (h, v) = (accuracy.horizontal_m, accuracy.vertical_m);
            writeln!(f, "accuracy = {{ horizontal_m = {h:?}, vertical_m = {v:?} }}")?;
        }
        SensorKind::Transponder(Transponder { accuracy: None, .. }) => writeln!(f, "# accuracy: not stated")?,
    }
    if let SensorKind::Transponder(Transponder { delay_s, max_new_per_s, .. }) = &sensor.kind {
        optional(f, "delay_s", *delay_s, "not known")?;
        writeln!(f, "max_new_per_s = {max_new_per_s}")?;
    }
    list(f, "inputs", &sensor.inputs, show_input)
}

fn show_radar(f: &mut Formatter<'_>, radar: &Radar) -> fmt::Result {
    writeln!(f, "latitude_deg = {:?}", radar.latitude_deg)?;
    writeln!(f, "longitude_deg = {:?}", radar.longitude_deg)?;
    writeln!(f, "height_amsl_m = {:?}", radar.height_amsl_m)?;
    writeln!(f, "bearing_correction_deg = {:?}", radar.bearing_correction_deg)?;
    optional(f, "max_range_m", radar.max_range_m, "no limit")?;
    writeln!(f, "assumed_height_amsl_m = {:?}", radar.assumed_height_amsl_m)?;
    match radar.classification {
        Classification::SpecialPurpose { octet } => {
            writeln!(f, "classification = {{ source = \"special-purpose\", octet = {octet} }}")?;
        }
        Classification::TargetClassification => {
            writeln!(f, "classification = {{ source = \"target-classification\" }}")?;
        }
        Classification::Constant { value } => {
            writeln!(f, "classification = {{ source = \"constant\", value = {value:?} }}")?;
        }
    }
    writeln!(f, "registration = \"{}\"", radar.registration.name())?;
    let Some(accuracy) = radar.accuracy else { return writeln!(f, "# accuracy: not stated") };
    write!(f, "accuracy = {{ range_m = {:?}, azimuth_deg = {:?}", accuracy.range_m, accuracy.azimuth_deg)?;
    if let Some(height_m) = accuracy.height_m {
        write!(f, ", height_m = {height_m:?}")?;
    }
    writeln!(f, " }}")
}

fn fusion(f: &mut Formatter<'_>, fusion: &Fusion) -> fmt::Result {
    let seconds = |f: &mut Formatter<'_>, key: &str, time: SignedDuration| {
        writeln!(f, "{key} = {:?}", time.as_secs_f64())
    };
    writeln!(f, "\n[fusion]\nprofile = \"{}\"", fusion.profile.name())?;
    writeln!(f, "motion = \"{}\"", fusion.motion.name())?;
    seconds(f, "slot_s", fusion.slot)?;
    seconds(f, "latency_s", fusion.latency())?;
    seconds(f, "window_s", fusion.window())?;
    seconds(f, "max_future_s", fusion.max_future)?;
    seconds(f, "max_gap_s", fusion.max_gap)?;
    let rows: Vec<_> = fusion.threshold_m.iter().map(|(range, d)| format!("[{range:?}, {d:?}]")).collect();
    writeln!(f, "threshold_m = [{}]", rows.join(", "))?;
    writeln!(f, "ratio_min = {:?}", fusion.ratio_min)?;
    writeln!(f, "min_samples = {}", fusion.min_samples)?;
    writeln!(f, "weight_radar = {:?}", fusion.weight_radar)?;
    writeln!(f, "weight_transponder = {:?}", fusion.weight_transponder)?;
    writeln!(f, "radar_only_min_s = {:?}", fusion.radar_only_min_s)?;
    seconds(f, "suppress_s", fusion.suppress())?;
    let numbers = fusion.transponder_numbers.iter();
    let numbers: Vec<_> = numbers.map(|(serial, number)| format!("{} = {number}", quoted(serial))).collect();
    writeln!(f, "transponder_numbers = {{ {} }}", numbers.join(", "))
}

fn output(f: &mut Formatter<'_>, output: &Output) -> fmt::Result {
    writeln!(f, "\n[output]")?;
    list(f, "asterix", &output.asterix, show_sink)?;
    let serial = match output.serial {
        SerialSource::Uas => "uas",
        SerialSource::TrackNumber => "track-number",
    };
    writeln!(f, "serial = \"{serial}\"\nstatus = {}", output.status)?;
    writeln!(f, "flush_on_stop = {}", output.flush_on_stop)?;
    let Some(record) = &output.record else { return writeln!(f, "# record: nothing is recorded") };
    let dir = quoted(&record.dir.to_string_lossy());
    writeln!(f, "record = {{ dir = {dir}, rotate_mib = {}, keep = {} }}", record.rotate_mib, record.keep)
}

fn http(f: &mut Formatter<'_>, http: &Http) -> fmt::Result {
    writeln!(f, "\n[http]\nlisten = \"{}\"", http.listen)?;
    match &http.auth {
        Auth::None => writeln!(f, "auth = {{ mode = \"none\" }}")?,
        Auth::Tokens { tokens_file } => {
            let file = quoted(&tokens_file.to_string_lossy());
            writeln!(f, "auth = {{ mode = \"tokens\", tokens_file = {file} }}")?;
        }
    }
    match &http.tls {
        Some(TlsFiles { certificate, key }) => {
            let [certificate, key] = [certificate, key].map(|file| quoted(&file.to_string_lossy()));
            writeln!(f, "tls = {{ certificate = {certificate}, key = {key} }}")?;
        }
        None => writeln!(f, "# tls: none, plain HTTP")?,
    }
    let texts = |texts: &[String]| texts.iter().map(|text| quoted(text)).collect::<Vec<_>>().join(", ");
    writeln!(f, "cors = [{}]", texts(&http.cors))?;
    writeln!(f, "hosts = [{}]", texts(&http.hosts))?;
    let proxies: Vec<String> = http.trusted_proxies.iter().map(ToString::to_string).collect();
    writeln!(f, "trusted_proxies = [{}]", texts(&proxies))?;
    writeln!(f, "connections_per_address = {}", http.connections_per_address.map_or(0, NonZeroU32::get))?;
    match http.limit {
        Some(RateLimit { requests_per_s, burst }) => {
            writeln!(f, "requests_per_s = {requests_per_s}\nrequests_burst = {burst}")?;
        }
        None => writeln!(f, "requests_per_s = 0")?,
    }
    match &http.tiles {
        Some(Tiles { url, attribution }) => {
            let (url, attribution) = (quoted(url), quoted(attribution));
            writeln!(f, "tiles = {{ url = {url}, attribution = {attribution} }}")
        }
        None => writeln!(f, "# tiles: none, the page asks nobody but this service"),
    }
}

fn optional(f: &mut Formatter<'_>, key: &str, value: Option<f64>, absent: &str) -> fmt::Result {
    match value {
        Some(value) => writeln!(f, "{key} = {value:?}"),
        None => writeln!(f, "# {key}: {absent}"),
    }
}

fn list<T>(f: &mut Formatter<'_>, key: &str, items: &[T], show: impl Fn(&T) -> String) -> fmt::Result {
    if items.is_empty() {
        return writeln!(f, "{key} = []");
    }
    writeln!(f, "{key} = [")?;
    for item in items {
        writeln!(f, "    {{ {} }},", show(item))?;
    }
    writeln!(f, "]")
}

fn show_address(address: Address, port: u16) -> String {
    match address {
        Address::Multicast { group, interface } => {
            format!("group = \"{group}\", port = {port}, interface = \"{interface}\"")
        }
        Address::Unicast(address) => format!("address = \"{address}\", port = {port}"),
    }
}

fn show_input(input: &Input) -> String {
    let source = input.source.map(|source| format!(", source = \"{source}\""));
    let trailer = input.trailer_octets.map(|octets| format!(", trailer_octets = {octets}"));
    show_address(input.address, input.port) + &source.unwrap_or_default() + &trailer.unwrap_or_default()
}

fn show_sink(sink: &Sink) -> String {
    format!("{}, ttl = {}", show_address(sink.address, sink.port), sink.ttl)
}
