//! The table and the picture of docs/bring-up.md.

use std::fmt::Write;
use std::path::PathBuf;

use emulated_board::time::{TICKS_PER_US, Ticks, seconds};

use crate::scope::Scope;

/// Set to write them anew.
const RENEW: &str = "RENEW_BOARD_FIGURES";
const BEGIN: &str = "<!-- by tests/board/tests/bring_up -->\n";
const END: &str = "<!-- end -->\n";

/// A step, what to look at, what is there; the reader's own column stays empty.
pub struct Row {
    /// When it is seen.
    at: Ticks,
    doing: String,
    probe: &'static str,
    shows: String,
}

impl Row {
    pub fn new(at: Ticks, doing: impl Into<String>, probe: &'static str, shows: String) -> Self {
        Self { at, doing: doing.into(), probe, shows }
    }
}

fn docs(name: &str) -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../docs").join(name)
}

fn table(rows: &[Row]) -> String {
    let mut text = "| | do | look at | it shows | seen |\n|---|---|---|---|---|\n".to_owned();
    for (number, Row { doing, probe, shows, .. }) in (1..).zip(rows) {
        let _ = writeln!(text, "| {number} | {doing} | {probe} | {shows} | |");
    }
    text
}

/// What stands on the page before, in and after the table.
fn parts(page: &str) -> Option<[&str; 3]> {
    let (before, rest) = page.split_once(BEGIN)?;
    let (inside, after) = rest.split_once(END)?;
    Some([before, inside, after])
}

/// Writes both, if told to.
pub fn renew(rows: &[Row], scope: &Scope) {
    if std::env::var_os(RENEW).is_none() {
        return;
    }
    let page = std::fs::read_to_string(docs("bring-up.md")).unwrap();
    let [before, _, after] = parts(&page).expect("a place for the table");
    std::fs::write(docs("bring-up.md"), format!("{before}{BEGIN}{}{END}{after}", table(rows))).unwrap();
    std::fs::write(docs("bring-up.svg"), picture(rows, scope)).unwrap();
}

/// Compares the table with the page's.
pub fn compare(rows: &[Row]) {
    let page = std::fs::read_to_string(docs("bring-up.md")).unwrap();
    let [_, inside, _] = parts(&page).expect("a place for the table");
    let found = table(rows);
    println!("{found}");
    assert!(found == inside, "docs/bring-up.md is not what was seen; renew it: {RENEW}=1 cargo xtask board-test");
}

const LEFT: f64 = 60.0;
const WIDTH: f64 = 860.0;
const BAND: f64 = 110.0;
/// Of a band: 1000 to 1500 us.
const US_PER_BAND: f64 = 500.0;
const BIN_S: f64 = 0.05;
const COLOURS: [&str; 4] = ["#1b6ca8", "#c8553d", "#3f8f4f", "#7b4fa3"];

/// Pulse width over time on AUX 1 to 4, one band each, the table's numbers above.
fn picture(rows: &[Row], scope: &Scope) -> String {
    let end_s = scope.pulses.iter().map(|pulse| seconds(pulse.rise)).fold(0.0, f64::max).ceil();
    let x = |time_s: f64| LEFT + WIDTH * time_s / end_s;
    let height = 4.0 * BAND + 70.0;
    let mut svg = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {} {height}\" font-family=\"sans-serif\" \
         font-size=\"12\">\n<rect width=\"100%\" height=\"100%\" fill=\"#fff\"/>\n",
        LEFT + WIDTH + 20.0
    );
    let mut labelled = None;
    for (number, Row { at, .. }) in (1..).zip(rows) {
        if labelled.replace(*at) != Some(*at) {
            let at = x(seconds(*at));
            let _ =
                write!(svg, "<text x=\"{at:.1}\" y=\"14\" text-anchor=\"middle\" font-weight=\"bold\">{number}</text>");
            let _ = writeln!(
                svg,
                "<line x1=\"{at:.1}\" x2=\"{at:.1}\" y1=\"18\" y2=\"{:.0}\" stroke=\"#eee\"/>",
                height - 40.0
            );
        }
    }
    for (aux, colour) in (1..=4).zip(COLOURS) {
        let floor = 20.0 + BAND * aux as f64;
        let y = |width_us: f64| floor - (BAND - 20.0) * (width_us - 1000.0) / US_PER_BAND;
        let _ = write!(svg, "<text x=\"4\" y=\"{:.0}\">AUX {aux}</text>", floor - 40.0);
        for width_us in [1000.0, 1250.0, 1500.0] {
            let _ = writeln!(
                svg,
                "<line x1=\"{LEFT}\" x2=\"{}\" y1=\"{y1:.1}\" y2=\"{y1:.1}\" stroke=\"#ddd\"/>\
                 <text x=\"{LEFT}\" y=\"{:.1}\" font-size=\"9\" fill=\"#777\">{width_us}</text>",
                LEFT + WIDTH,
                y(width_us) - 2.0,
                y1 = y(width_us),
            );
        }
        for line in traces(scope, aux) {
            let points: Vec<_> = line.iter().map(|(s, us)| format!("{:.1},{:.1}", x(*s), y(*us))).collect();
            let _ = writeln!(svg, "<polyline fill=\"none\" stroke=\"{colour}\" points=\"{}\"/>", points.join(" "));
        }
    }
    for second in (0..=end_s as u32).step_by(2) {
        let _ = write!(svg, "<text x=\"{:.0}\" y=\"{:.0}\">{second}</text>", x(f64::from(second)), height - 20.0);
    }
    let _ = writeln!(
        svg,
        "<text x=\"{LEFT}\" y=\"{}\">width of the pulses, us, over time, s; above: step of the table</text></svg>",
        height - 4.0
    );
    svg
}

/// Mean widths of an output in bins; a new line wherever there were no pulses.
fn traces(scope: &Scope, aux: usize) -> Vec<Vec<(f64, f64)>> {
    let mut bins: Vec<(f64, f64)> = Vec::new();
    for pulse in scope.pulses.iter().filter(|pulse| pulse.aux == aux) {
        let bin = (seconds(pulse.rise) / BIN_S) as usize;
        bins.resize(bins.len().max(bin + 1), (0.0, 0.0));
        bins[bin].0 += pulse.width as f64 / TICKS_PER_US as f64;
        bins[bin].1 += 1.0;
    }
    let (mut lines, mut line) = (Vec::new(), Vec::new());
    for (bin, (sum, count)) in bins.into_iter().enumerate() {
        // lines that are high before the image runs are no pulses
        if count > 0.0 && sum / count >= 999.0 {
            line.push(((bin as f64 + 0.5) * BIN_S, sum / count));
        } else if !line.is_empty() {
            lines.push(std::mem::take(&mut line));
        }
    }
    lines.push(line);
    lines
}
