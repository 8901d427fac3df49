//! Every kind of line, octet by octet.

use utm_fusion::commands::decode;

use super::{Temporary, block, octets, pcap};

/// Output of `decode` for a file with these octets.
fn decoded(name: &str, octets: &[u8]) -> Vec<String> {
    let file = Temporary::new(name, octets);
    let args = decode::Args { inputs: vec![file.0.clone()], ..decode::Args::default() };
    let mut out = Vec::new();
    decode::run(&args, &mut out).unwrap();
    String::from_utf8(out).unwrap().lines().map(str::to_owned).collect()
}

#[test]
fn every_item_of_cat048() {
    let record = "fffffffe \
        19c8 48b720 a0 00e118e0 0804 3ffb fe18040b1cf60afd 4a08eb 48f534c75820 \
        01 01020304050607 40 0783 0100ff80 4000 8000 a6 01020304 26 0801 0abc0102 0014 \
        c0 83fe 01 000100020003 20fd 30010203040506 5f 0abc 1e 0800 03aabb 02cc";
    let lines = decoded("all048", &block(48, &[record]));
    assert_eq!(
        lines,
        [concat!(
            r#"{"time":null,"offset":3,"block":0,"cat":48,"sac":25,"sic":200,"items":{"#,
            r#""010":{"sac":25,"sic":200},"140":37230.25,"#,
            r#""020":{"typ":5,"sim":0,"rdp":0,"spi":0,"rab":0},"#,
            r#""040":{"rho_m":1627.7,"theta_deg":34.98},"070":{"v":0,"g":0,"l":0,"mode_3a":"4004"},"#,
            r#""090":{"v":0,"g":0,"flight_level":-1.25},"#,
            r#""130":{"srl_deg":1.05,"srr":4,"sam_dbm":11,"prl_deg":1.23,"pam_dbm":-10,"rpd_m":72.3,"apd_deg":-0.066},"#,
            r#""220":"4A08EB","240":"ROT415  ","250":[{"data":"01020304050607","bds1":4,"bds2":0}],"#,
            r#""161":{"track_number":1923},"042":{"x_m":3704.0,"y_m":-1852.0},"#,
            r#""200":{"speed_m_s":1852.0,"heading_deg":180.0},"#,
            r#""170":{"cnf":1,"rad":1,"dou":0,"mah":0,"cdm":3},"#,
            r#""210":{"sigma_x_m":14.5,"sigma_y_m":28.9,"sigma_v_m_s":0.34,"sigma_h_deg":0.35},"030":[19],"#,
            r#""080":{"low_quality":"4001"},"100":{"v":0,"g":0,"mode_c_gray":"abc","low_quality":"102"},"#,
            r#""110":{"height_m":152.4},"#,
            r#""120":{"cal":{"d":1,"speed_m_s":-2},"rds":[{"doppler_m_s":1,"ambiguity_m_s":2,"frequency_mhz":3}]},"#,
            r#""230":{"com":1,"stat":0,"si":0,"mssc":1,"arc":1,"aic":1,"b1a":1,"b1b":13},"260":"30010203040506","#,
            r#""055":{"v":0,"g":1,"l":0,"mode_1":31},"050":{"v":0,"g":0,"l":0,"mode_2":"5274"},"#,
            r#""065":{"low_quality":30},"060":{"low_quality":"4000"},"SP":"03aabb","RE":"02cc"}}"#,
        )]
    );
}

/// The items of a block with one record.
fn items(name: &str, category: u8, record: &str) -> String {
    let lines = decoded(name, &block(category, &[record]));
    let [line] = lines.as_slice() else { panic!("not one line: {lines:?}") };
    line[line.find(r#""items":"#).unwrap() + 8..line.len() - 1].to_owned()
}

#[test]
fn the_reserved_expansion_field_of_cat048() {
    // MD5 (SUM), M4E, ERR, RTC (TRN, TLC), CPC (RPL), GEN48 (RCSDB).
    let field = "80 a2 06 000100 2180 32 c0010100 40 02010007000000 10 3f9c";
    let record = format!("8101 01 02 1907 {:02x} af {field}", octets(field).len() + 2);
    assert_eq!(
        items("re", 48, &record),
        concat!(
            r#"{"010":{"sac":25,"sic":7},"RE":{"md5":{"sum":{"m5":1,"id":0,"da":1,"m1":0,"m2":0,"m3":0,"mc":1}},"m4e":{"foe_fri":3},"#,
            r#""err_m":1852.0,"rtc":{"trn_percent":50,"tlc":{"acqi":3,"updates":1,"last_update_ms":256}},"#,
            r#""cpc":{"rpl":[{"type":1,"reply_number":7},{"type":0,"reply_number":0}]},"gen48":{"rcsdb":{"dbm2":-1.0}}}}"#,
        )
    );
}

#[test]
fn cat034() {
    let record = "fff8 1907 02 48b720 40 0200 94 a2 60 4080 98 5a d4 20 01 2fff 0100020040008000 03 \
        0069255555d55555 ff80";
    assert_eq!(
        items("034", 34, record),
        concat!(
            r#"{"010":{"sac":25,"sic":7},"000":2,"030":37230.25,"020":{"azimuth_deg":90.0},"041":{"period_s":4.0},"#,
            r#""050":{"com":{"nogo":1,"rdpc":0,"rdpr":1,"ovl_rdp":0,"ovl_xmt":0,"msc":0,"tsv":1},"#,
            r#""psr":{"ant":0,"chab":3,"ovl":0,"msc":0},"#,
            r#""mds":{"ant":0,"chab":2,"ovl_sur":0,"msc":0,"scf":0,"dlf":0,"ovl_scf":0,"ovl_dlf":1}},"#,
            r#""060":{"com":{"red_rdp":5,"red_xmt":5},"psr":{"pol":1,"red_rad":5,"stc":1},"ssr":{"red_rad":1}},"#,
            r#""070":[{"typ":5,"count":2047}],"#,
            r#""100":{"rho_start_m":1852.0,"rho_end_m":3704.0,"theta_start_deg":90.0,"theta_end_deg":180.0},"110":3,"#,
            r#""120":{"height_m":105,"latitude_deg":52.49999,"longitude_deg":-60.00001},"#,
            r#""090":{"range_m":-14.5,"azimuth_deg":-2.813}}"#,
        )
    );
}

#[test]
fn cat065() {
    assert_eq!(
        items("065", 65, "ff06 1907 01 03 48b720 02 7a 10 02aa 02bb"),
        concat!(
            r#"{"010":{"sac":25,"sic":7},"000":1,"015":3,"030":37230.25,"020":2,"#,
            r#""040":{"nogo":1,"ovl":1,"tsv":1,"pss":2,"sttn":1},"050":16,"RE":"02aa","SP":"02bb"}"#,
        )
    );
}

#[test]
fn every_item_of_cat129() {
    let record = "bff380 1907 414952 444954 313233343536373834303935 4652 546040 115f094b 00d61a3c 0004d2 0001c8 0003 \
        0012cfff6a 0fff1f";
    let items = concat!(
        r#""020":"AIR","030":"DIT","040":"123456784095","050":"FR","070":43200.5,"#,
        r#""080":{"latitude_deg":48.85659998,"longitude_deg":2.35220008},"090":{"altitude_m":123.4},"#,
        r#""100":{"altitude_m":45.6},"110":{"accuracy_m":3}"#,
    );
    let velocities = r#""185":{"east_m_s":3.0,"north_m_s":-1.5},"220":{"up_m_s":-2.25}"#;
    assert_eq!(
        decoded("some129", &block(129, &[record])),
        [format!(
            r#"{{"time":null,"offset":3,"block":0,"cat":129,"sac":25,"sic":7,"items":{{"010":{{"sac":25,"sic":7}},{items},{velocities}}}}}"#
        )]
    );
    // With all items: destination, risk with three octets, the service's own special purpose field.
    let record = "ffff80 1907 2009 414952 444954 313233343536373834303935 4652 546040 115f094b 00d61a3c 0004d2 0001c8 \
        0003 a90102 16554601 01 0000002a 0783 ffffffff 0064 ffff a1 7f 00 0012cfff6a 0fff1f";
    assert_eq!(
        decoded("all129", &block(129, &[record])),
        [format!(
            r#"{{"time":null,"offset":3,"block":0,"cat":129,"sac":25,"sic":7,"items":{{"010":{{"sac":25,"sic":7}},"015":{{"dac":32,"dic":9}},{items},{rest},{velocities}}}}}"#,
            rest = concat!(
                r#""120":{"certification_category":2,"air_risk_category":3,"airspace_encounter_category":9,"undescribed":"0102"},"#,
                r#""SP":{"uf":{"source":1,"track_number":42,"radar_track":1923,"transponder":null,"#,
                r#""horizontal_deviation_m":10.0,"vertical_deviation_m":null,"spare":2,"height_not_measured":1,"uncooperative":0,"#,
                r#""integrity_failed":0,"integrity_suspect":0,"extrapolated":0,"interpolated":1,"uav_probability":0.5}}"#,
            ),
        )]
    );
}

#[test]
fn extensions_and_what_no_edition_names() {
    assert_eq!(
        decoded("extensions", &block(48, &["20 21 7f d3 97 3b a7 15 42"])),
        [concat!(
            r#"{"time":null,"offset":3,"block":0,"cat":48,"items":{"020":{"#,
            r#""typ":1,"sim":0,"rdp":0,"spi":0,"rab":0,"#,
            r#""tst":0,"err":1,"xpp":1,"me":1,"mi":1,"foe_fri":3,"#,
            r#""adsb_ep":1,"adsb":1,"scn_ep":0,"scn":1,"pai_ep":0,"pai":0,"spare_3":1,"#,
            r#""acasxv_ep":1,"acasxv":2,"poxpr_ep":1,"poxpr":1,"#,
            r#""poact_ep":0,"poact":0,"dtfxpr_ep":1,"dtfxpr":1,"dtfact_ep":1,"dtfact":0,"spare_5":1,"#,
            r#""irmxpr_ep":1,"irmxpr":0,"irmact_ep":1,"irmact":0,"spare_6":3,"more":"1542"}}}"#,
        )]
    );
}

#[test]
fn spare_bits_and_octets_without_meaning_are_kept() {
    // I048/070, 161, 110 with spare bits set; I048/240 with an undefined character; an FSPEC with a superfluous octet.
    let lines = decoded("spare048", &block(48, &["09 51 09 00 f804 000000000000 f783 fffe"]));
    assert_eq!(
        lines,
        [concat!(
            r#"{"time":null,"offset":3,"block":0,"cat":48,"fspec":"09510900","items":{"#,
            r#""070":{"v":1,"g":1,"l":1,"spare":1,"mode_3a":"4004"},"240":{"hex":"000000000000"},"#,
            r#""161":{"spare":15,"track_number":1923},"110":{"spare":3,"height_m":-15.24}}}"#
        )]
    );
    // I129/040 that is no text, 110 unknown, an SP with another layout and one with its spare octet set, 220 spare.
    let foreign = block(129, &["09 15 80 00 3132333435363738394142 0000 03aabb ffff1f"]);
    let spare = block(129, &["01 04 16554601 01 0000002a 0783 ffffffff 0064 ffff 01 7f 01"]);
    let lines = decoded("spare129", &[foreign, spare].concat());
    assert_eq!(
        lines[0],
        concat!(
            r#"{"time":null,"offset":3,"block":0,"cat":129,"items":{"040":{"hex":"003132333435363738394142"},"#,
            r#""110":{"accuracy_m":null},"SP":"03aabb","220":{"spare":15,"up_m_s":-2.25}}}"#
        )
    );
    assert!(lines[1].contains(r#""uav_probability":0.5,"spare_2":1}"#), "{}", lines[1]);
    let other = items("version", 129, "81 04 1907 16554602 01 0000002a 0783 ffffffff 0064 ffff 01 7f 00");
    assert_eq!(other, r#"{"010":{"sac":25,"sic":7},"SP":"16554602010000002a0783ffffffff0064ffff017f00"}"#);
}

#[test]
fn times_are_of_the_day_nearest_to_the_reception() {
    const MIDNIGHT: u32 = 20_000 * 86_400;
    let last = block(48, &["40 a8bfff"]); // the last count of a day
    let (file, origins) = pcap(&[
        (MIDNIGHT + 1, &last),
        (MIDNIGHT - 1, &block(129, &["02 000010"])),
        (MIDNIGHT, &block(48, &["40 ffffff"])),
        (MIDNIGHT, &block(48, &["80 1907"])),
    ]);
    let lines = decoded("midnight", &file);
    let place = |index: usize| format!(r#""offset":{},"block":{}"#, origins[index] + 3, origins[index]);
    let expected = [
        format!(
            r#"{{"time":"2024-10-03T23:59:59.992Z",{},"cat":48,"items":{{"140":86399.9921875}}}}"#,
            place(0)
        ),
        format!(r#"{{"time":"2024-10-04T00:00:00.125Z",{},"cat":129,"items":{{"070":0.125}}}}"#, place(1)),
        format!(r#"{{"time":null,{},"cat":48,"items":{{"140":131071.9921875}}}}"#, place(2)),
        format!(
            r#"{{"time":null,{},"cat":48,"sac":25,"sic":7,"items":{{"010":{{"sac":25,"sic":7}}}}}}"#,
            place(3)
        ),
    ];
    assert_eq!(lines, expected);
}

#[test]
fn faults_say_where_and_keep_the_octets() {
    let file = [
        block(48, &["80 1907", "a0 1908 01"]), // the second record: its I048/020 is not terminated
        block(61, &["0102"]),
        block(48, &[]),
        block(129, &["8101 04 1907"]), // an item that the category does not define
        octets("30 0002 ff"),
    ]
    .concat();
    let lines = decoded("faults", &file);
    assert_eq!(
        lines,
        [
            r#"{"time":null,"offset":3,"block":0,"cat":48,"sac":25,"sic":7,"items":{"010":{"sac":25,"sic":7}}}"#,
            concat!(
                r#"{"error":{"kind":"item_past_end","offset":9,"item":"020","#,
                r#""detail":"CAT048 item 020 at octet 9: the item runs past the end of its block"},"#,
                r#""offset":6,"block":0,"cat":48,"hex":"a0190801"}"#
            ),
            r#"{"time":null,"offset":10,"block":10,"cat":61,"hex":"3d00050102"}"#,
            r#"{"time":null,"offset":15,"block":15,"cat":48,"hex":"300003"}"#,
            concat!(
                r#"{"error":{"kind":"reserved_frn","offset":23,"#,
                r#""detail":"CAT129 at octet 23: the FSPEC announces an item that the category does not define"},"#,
                r#""offset":21,"block":18,"cat":129,"hex":"8101041907"}"#
            ),
            concat!(
                r#"{"error":{"kind":"block_too_short","offset":26,"#,
                r#""detail":"CAT048 at octet 26: the block's LEN is below 3, the size of its own header"},"#,
                r#""offset":26,"block":26,"cat":48,"hex":"300002ff"}"#
            ),
        ]
    );
}

#[test]
fn several_records_and_blocks_of_a_datagram() {
    let first = block(48, &["80 1907", "80 1908"]);
    let second = block(129, &["80 0000"]);
    let (file, origins) = pcap(&[(0, b"padding"), (0, &[first.clone(), second].concat())]);
    let lines = decoded("several", &file);
    let origin = origins[1];
    let places: Vec<String> = [(3, 0), (6, 0), (first.len() + 3, first.len())]
        .map(|(offset, block)| format!(r#""offset":{},"block":{}"#, origin + offset, origin + block))
        .into();
    assert_eq!(lines.len(), 4);
    for (line, place) in lines[1..].iter().zip(places) {
        assert!(line.contains(&place), "{line} {place}");
    }
}
