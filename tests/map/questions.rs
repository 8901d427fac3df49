//! Questions of an operator, answered from the screen alone. The API has the right answers.

use std::fs;

use serde_json::Value;

use super::browser::Browser;
use super::service::{self, Service};
use super::{BADGE, ROWS, SOON, fresh_folder, installed};

const LIST: &str = "document.getElementById('alert-list').innerText";
const DETAIL: &str = "document.getElementById('detail').innerText";

/// A question, and an expression that is true if the screen answers it.
type Answer = (&'static str, String);

#[test]
fn screen_answers_the_questions_of_an_operator() {
    let Some(program) = installed() else { return };
    let folder = fresh_folder("map-questions");
    service::simulate(&folder, "spoof");
    // The radar falls silent some seconds after the lie is found.
    let radar = fs::read(folder.join("radar.ast")).unwrap();
    fs::write(folder.join("radar.ast"), &radar[..radar.len() / 10 * 7]).unwrap();
    let service = Service::replay_in("operational", &folder, 0);
    service.order("pause");
    service.seek("09:03:10");
    let mut browser = Browser::start(&program, &folder.join("profile"));
    browser.open(&service.url());
    browser.wait(&format!("{BADGE} === 'REPLAY paused' && {ROWS} > 2"), SOON);

    let tracks = service.get("/api/v1/tracks");
    let tracks = tracks["features"].as_array().unwrap();
    let mut answered = ask(&mut browser, &of_the_picture(tracks, &service));
    answered += ask(&mut browser, &of_the_lie(tracks, &service));
    let fused = tracks.iter().map(|track| &track["properties"]).find(|track| track["source"] == "fused");
    let fused = fused.expect("a fused track");
    let row = format!(
        "[...document.querySelectorAll('#table-body tr')].find(row => row.innerText.includes('{}'))",
        text(fused, "name")
    );
    browser.wait(&format!("{row} !== undefined"), SOON);
    browser.run(&format!("{row}.click()"));
    answered += ask(&mut browser, &of_the_selected(fused));
    service.seek("09:04:10");
    answered += ask(&mut browser, &of_the_silence(&service));
    assert!(answered >= 20, "{answered} questions");
}

/// Asks each question. Returns their number.
fn ask(browser: &mut Browser, questions: &[Answer]) -> usize {
    for (question, is_answered) in questions {
        println!("{question}");
        browser.wait(is_answered, SOON);
    }
    questions.len()
}

fn text<'a>(object: &'a Value, name: &str) -> &'a str {
    object[name].as_str().unwrap_or_else(|| panic!("no {name} in {object}"))
}

fn of_the_picture(tracks: &[Value], service: &Service) -> Vec<Answer> {
    let of_source =
        |source: &str| tracks.iter().filter(|track| track["properties"]["source"] == source).count();
    let shows = |source: &str| {
        let count = "querySelector('.count').textContent";
        format!(
            "document.querySelector('#sources [data-source={source}]').{count} === '{}'",
            of_source(source)
        )
    };
    let alerts = service.get("/api/v1/alerts");
    let waiting = alerts["alerts"].as_array().unwrap().len() + alerts["latched"].as_array().unwrap().len();
    vec![
        ("Is this now, or a recording?", format!("{BADGE} === 'REPLAY paused'")),
        ("Which time do I see?", "document.getElementById('utc').innerText.includes('09:03:1')".to_owned()),
        ("How many are seen by radar and transponder?", shows("fused")),
        ("How many have no transponder?", shows("radar")),
        ("How many does no radar see?", shows("transponder")),
        (
            "How many situations need me?",
            format!("document.getElementById('alert-count').textContent === '{waiting}'"),
        ),
        (
            "Which sensors are there?",
            "/gamekeeper/.test(document.getElementById('sensors').innerText)".to_owned(),
        ),
    ]
}

fn of_the_lie(tracks: &[Value], service: &Service) -> Vec<Answer> {
    let alerts = service.get("/api/v1/alerts?kind=integrity");
    let alert = &alerts["alerts"][0];
    let name_of = |id: &str| {
        let track = tracks.iter().map(|track| &track["properties"]).find(|track| track["id"] == id);
        text(track.unwrap_or_else(|| panic!("no track {id}")), "name").to_owned()
    };
    let (liar, twin) = (name_of(text(alert, "track_id")), name_of(text(alert, "twin_id")));
    let since = &text(alert, "since")[11..19];
    let says = |words: &str| format!("{LIST}.includes('{words}')");
    vec![
        ("Which transponder is not trusted?", says(&format!("transponder {liar} is"))),
        ("Since when?", says(&format!("since {since} UTC"))),
        ("Why?", says("because radar sees the aircraft")),
        ("How far is it off?", format!("/\\d+ m from where it says it is/.test({LIST})")),
        ("Where is the aircraft?", says(&twin)),
        ("What do I do?", format!("/do not use its position|look at/.test({LIST})")),
    ]
}

fn of_the_selected(track: &Value) -> Vec<Answer> {
    let says = |words: &str| format!("{DETAIL}.includes('{words}')");
    let number =
        |name: &str| format!("{:.1}", track[name].as_f64().unwrap_or_else(|| panic!("no {name} in {track}")));
    vec![
        (
            "What is it called?",
            format!("document.querySelector('#detail h2').innerText.includes('{}')", text(track, "name")),
        ),
        ("Whose is it?", says(text(&track["uas_id"], "serial_number"))),
        ("How high is it?", says(&number("alt_msl"))),
        ("How fast is it?", says(&number("speed"))),
        ("How well is its position known?", says(&number("accuracy_h_m"))),
        ("Which radar sees it?", says("gamekeeper")),
        ("Is its transponder to be trusted?", says(text(track, "integrity"))),
        ("How do I follow it?", "document.getElementById('follow').checkVisibility()".to_owned()),
    ]
}

fn of_the_silence(service: &Service) -> Vec<Answer> {
    let alerts = service.get("/api/v1/alerts?kind=sensor");
    let alert = &alerts["alerts"][0];
    assert_eq!((&alert["sensor"], &alert["severity"]), (&"gamekeeper".into(), &"critical".into()), "{alert}");
    vec![
        ("Which sensor is silent?", format!("{LIST}.includes('gamekeeper outage')")),
        ("Since when?", format!("{LIST}.includes('since {} UTC')", &text(alert, "since")[11..19])),
        (
            "Is the picture whole?",
            "document.querySelector('#sensors [data-look=critical]').innerText.includes('gamekeeper')"
                .to_owned(),
        ),
    ]
}
