//! Tests of `[fusion]`.

use super::*;

#[test]
fn fusion_rules() {
    let slot = "slot_s = 0.25";
    for (new, place, message) in [
        ("profile = \"best\"", "23: fusion.profile = \"best\"", "use \"operational\" or \"reference\""),
        ("motion = \"kalman\"", "23: fusion.motion = \"kalman\"", "use \"imm\" or \"singer\""),
        ("motion = 1", "23: fusion.motion = 1", "expected text in quotes"),
        ("slot_s = 0", "23: fusion.slot_s = 0", "whole number of milliseconds"),
        ("slot_s = 0.0005", "23: fusion.slot_s", "whole number of milliseconds"),
        ("slot_s = -1", "23: fusion.slot_s", "whole number of milliseconds"),
        (
            "slot_s = 0.5",
            "23: fusion.slot_s = 0.5",
            "latency_s is a whole number of slots (slot_s = 0.5), and 6.25",
        ),
        ("latency_s = 6.3", "23: fusion.latency_s = 6.3", "set it to 6.25 or 6.5"),
        ("latency_s = 0\nprofile = \"reference\"", "23: fusion.latency_s = 0", "at least one slot"),
        ("now = true\nprofile = \"reference\"", "23: fusion.now = true", "no picture of now"),
        ("now = 1", "23: fusion.now = 1", "true or false"),
        ("latency_s = 25", "23: fusion.latency_s = 25", "shorter than window_s"),
        ("window_s = 6.25", "23: fusion.window_s = 6.25", "shorter than window_s"),
        ("window_s = 25.1", "23: fusion.window_s", "whole number of slots"),
        ("window_s = 30.75", "23: fusion.window_s", "at most 126 slots, here 31.5 seconds"),
        ("slot_s = 0.125", "23: fusion.slot_s", "at most 126 slots, here 15.75 seconds"),
        ("suppress_s = 0.1", "23: fusion.suppress_s", "whole number of slots"),
        ("suppress_s = 25.25", "23: fusion.suppress_s", "at most window_s"),
        ("max_future_s = 6.5", "23: fusion.max_future_s", "at most latency_s"),
        ("max_future_s = -1", "23: fusion.max_future_s", "at least 0"),
        ("latency_s = 0.75\nmax_future_s = 1", "24: fusion.max_future_s", "at most latency_s"),
        ("max_gap_s = 0", "23: fusion.max_gap_s", "above 0"),
        ("max_gap_s = inf", "23: fusion.max_gap_s", "at most 86400"),
        ("threshold_m = []", "23: fusion.threshold_m = []", "no row"),
        ("threshold_m = [[1, 2],\n [1, 3]]", "24: fusion.threshold_m[1] = [1, 3]", "rise from row to row"),
        ("threshold_m = [[0, 0]]", "23: fusion.threshold_m[0][1] = 0", "above 0"),
        ("threshold_m = [[-1, 2]]", "23: fusion.threshold_m[0][0]", "at least 0"),
        ("threshold_m = [[1, 2, 3]]", "23: fusion.threshold_m[0] = [1, 2, 3]", "a row is [slant range"),
        ("threshold_m = 60", "23: fusion.threshold_m = 60", "expected a list"),
        ("ratio_min = 0", "23: fusion.ratio_min = 0", "above 0 and at most 1"),
        ("ratio_min = 1.01", "23: fusion.ratio_min", "above 0 and at most 1"),
        ("min_samples = 0", "23: fusion.min_samples = 0", "at least 1"),
        ("min_samples = 101", "23: fusion.min_samples = 101", "at most the slots of window_s"),
        ("weight_radar = -1", "23: fusion.weight_radar = -1", "at least 0"),
        (
            "weight_radar = 0\nweight_transponder = 0",
            "24: fusion.weight_transponder = 0",
            "both weights are 0",
        ),
        ("radar_only_min_s = -1", "23: fusion.radar_only_min_s", "between 0 and 86400"),
        ("transponder_numbers = { A = 0 }", "23: fusion.transponder_numbers.A = 0", "1 to 429496"),
        ("transponder_numbers = { A = 429497 }", "23: fusion.transponder_numbers.A", "1 to 429496"),
        (
            "transponder_numbers = { A = 1, B = 1 }",
            "23: fusion.transponder_numbers.B = 1",
            "A has this number",
        ),
        ("transponder_numbers = { \" \" = 1 }", "23: fusion.transponder_numbers.\" \"", "serial is blank"),
        (
            "transponder_numbers = { A = 1, \"A \" = 2 }",
            "23: fusion.transponder_numbers.\"A \"",
            "there twice",
        ),
        (
            "transponder_numbers = { A234567890123 = 1 }",
            "23: fusion.transponder_numbers.A234567890123",
            "12 octets",
        ),
        ("latency = 5", "23: fusion.latency", "did you mean latency_s?"),
        ("ratoi_min = 1", "23: fusion.ratoi_min", "did you mean ratio_min?"),
        ("colour = 1", "23: fusion.colour", "unknown; expected here: profile, motion, slot_s, latency_s"),
    ] {
        check(&[(slot, new, place, message)]);
    }
    let operational = parse(&BASE.replace(slot, "profile = \"operational\"")).unwrap();
    assert_eq!(operational.fusion.profile, Profile::Operational);
    assert_eq!(operational.fusion.motion, Motion::Imm);
    let singer = parse(&BASE.replace(slot, "motion = \"singer\"")).unwrap();
    assert_eq!(singer.fusion.motion, Motion::Singer);
    assert!(singer.to_string().contains("\nmotion = \"singer\"\n"));
    let trimmed = parse(&BASE.replace(slot, "transponder_numbers = { \" DRONE 1 \" = 429496 }")).unwrap();
    assert_eq!(trimmed.fusion.transponder_numbers["DRONE 1"], 429_496);
}
