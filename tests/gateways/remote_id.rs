//! Remote ID from real radio transmissions, message by message, compared with the reference decoder, through the program.

use serde_json::Value;

use super::{decode, run, shared, unzip};

/// Checks that a message printed by `decode` equals that of the reference decoder.
fn agree(ours: &Value, theirs: &Value) {
    let number = |ours: &Value, name: &str, unknown: f64| {
        let (ours, theirs) = (ours.as_f64().unwrap_or(unknown), theirs[name].as_f64().unwrap());
        assert!((ours - theirs).abs() < 1e-6, "{name}: {ours}, {theirs}");
    };
    let kinds = ["basic_id", "location", "authentication", "self_id", "system", "operator_id"];
    assert_eq!(ours["message"], kinds[theirs["type"].as_u64().unwrap() as usize]);
    match ours["message"].as_str().unwrap() {
        "location" => {
            number(&ours["latitude_deg"], "lat", f64::NAN);
            number(&ours["longitude_deg"], "lon", f64::NAN);
            number(&ours["track_direction_deg"], "direction", 361.0);
            number(&ours["speed_m_s"], "speed_h", 255.0);
            number(&ours["vertical_speed_m_s"], "speed_v", 63.0);
            number(&ours["pressure_altitude_m"], "alt_baro", -1000.0);
            number(&ours["geodetic_altitude_m"], "alt_geo", -1000.0);
            number(&ours["height_m"], "height", -1000.0);
            number(&ours["timestamp_s"], "timestamp", f64::NAN);
            let states = ["undeclared", "ground", "airborne", "emergency", "system-failure"];
            if let Some(status) = ours["operational_status"].as_str() {
                assert_eq!(status, states[theirs["status"].as_u64().unwrap() as usize]);
            }
        }
        "system" => {
            number(&ours["operator_latitude_deg"], "op_lat", f64::NAN);
            number(&ours["operator_longitude_deg"], "op_lon", f64::NAN);
            number(&ours["area_count"], "area_count", f64::NAN);
            number(&ours["area_radius_m"], "area_radius", f64::NAN);
        }
        "basic_id" => {
            let ours = match &ours["uas_id"] {
                Value::String(text) => text.bytes().map(|octet| format!("{octet:02x}")).collect(),
                bare => bare["hex"].as_str().unwrap().to_owned(),
            };
            assert!(theirs["id_hex"].as_str().unwrap().starts_with(&ours), "{ours}");
        }
        _ => {}
    }
}

#[test]
fn captured_messages_match_the_reference_decoder() {
    let Some(folder) = shared::recordings().map(|data| data.join("remote-id-radio")) else { return };
    let mut compared = (0, 0);
    for (name, extension, heard, failed) in [
        ("parrot-anafi-wifi-60s", "pcap", 559, 0),
        ("test-transmitter-wifi-beacon", "pcap", 21, 0),
        ("test-transmitter-wifi-nan", "pcap", 42, 0),
        ("ble5-long-range-9s", "pcapng", 167, 25),
    ] {
        let path = folder.join(name).with_extension(extension);
        let theirs: Vec<Value> = unzip(&folder.join(format!("{name}.ndjson.gz")))
            .lines()
            .map(|line| serde_json::from_str(line).unwrap())
            .collect();
        let lines = decode(&path);
        let mut ours = lines.iter().peekable();
        let mut advertisements = 0;
        // The reference decoder also read frames with a failed checksum, which are missing here.
        for line in &theirs {
            let time = line["time"].as_str().unwrap();
            let Some(first) = ours.peek() else { break };
            let error_at = first["error"]["offset"].as_u64();
            let is_same = error_at.is_some() && line["decoded"].as_array().unwrap().is_empty()
                || first["time"].as_str().is_some_and(|ours| time.starts_with(&ours[..ours.len() - 1]));
            if !is_same {
                continue;
            }
            let (offset, mut decoded) = (first["offset"].clone(), line["decoded"].as_array().unwrap().iter());
            advertisements += 1;
            while let Some(message) = ours.next_if(|message| message["offset"] == offset) {
                if message["error"].is_object() {
                    // A message of an invalid kind, or an empty pack.
                    let refused = decoded.next();
                    assert!(
                        refused.is_none_or(|theirs| theirs["rc"] != 0 || theirs["type"].as_u64() > Some(5)),
                        "{message}"
                    );
                    continue;
                }
                assert_eq!(message["transmitter"], line["transmitter"]);
                agree(message, decoded.next().unwrap_or_else(|| panic!("{name}: {message}")));
                compared.0 += 1;
            }
            assert!(decoded.next().is_none(), "{name}: {line}");
        }
        assert!(ours.next().is_none(), "{name}: all are accounted for");
        compared.1 += advertisements;
        let (info, _) = run(&["info", path.to_str().unwrap()]);
        println!("{info}");
        assert_eq!(advertisements, heard, "{name}");
        assert_eq!(info.contains(&format!("{failed} with a failed checksum")), failed > 0, "{info}");
        assert!(info.contains("Remote ID  1 transmitter; "), "{info}");
    }
    assert_eq!(compared, (1_951, 789));
}
