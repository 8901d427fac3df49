//! Symbols that lie on one another: the map writes their number, and clicks select one after the other.

use super::{ROWS, SOON, paused};

#[test]
fn symbols_on_one_another_are_counted_and_clicked_in_turn() {
    let Some((_, service, mut browser)) = paused("map-crowds", "operational") else { return };
    browser.open(&service.url());
    browser.wait(&format!("{ROWS} > 2"), SOON);
    let of_modules = "import('./crowds.js').then(({ crowdsOf, chosenOf }) => { \
        const at = (id, x, y) => [{ id }, x, y, 0]; \
        const crowd = [at('a', 10, 10), at('b', 11, 10), at('c', 13, 12), at('d', 60, 10)]; \
        const click = (x, selected) => chosenOf(crowd, x, 10, 16, selected)?.id ?? 'none'; \
        return JSON.stringify([crowdsOf(crowd).map(([, , number]) => number), \
            [click(10, null), click(10, 'a'), click(10, 'b'), click(60, 'a'), click(300, 'a')]]); })";
    assert_eq!(browser.text(of_modules), r#"[[3],["a","b","a","d","none"]]"#);
    // Seen from far away, all lie on one another: the canvas has their number, and each click selects another one.
    browser.run("for (let step = 0; step < 12; step++) document.getElementById('zoom-out').click()");
    browser.run(
        "window.written = []; const { fillText } = CanvasRenderingContext2D.prototype; \
            CanvasRenderingContext2D.prototype.fillText = function (text, ...rest) { \
                written.push(text); fillText.call(this, text, ...rest); }; \
            document.getElementById('zoom-out').click()",
    );
    browser.wait("written.some(text => /^×\\d+$/.test(text))", SOON);
    assert_eq!(browser.complaints(), Vec::<String>::new(), "errors in the console");
}
