//! A report that the command line writes, in the hands of its reader: values under the cursor, one time axis for all
//! plots of a span, curves that the legend hides.

use std::fs;
use std::time::{Duration, Instant};

use anyhow::{Context, Result, ensure};
use page_test::{Browser, Mouse, Page};
use serde_json::{Value, json};
use tempfile::TempDir;

/// Length of the log, s.
const DURATION_S: f64 = 20.0;
/// Longer than a plot takes to be drawn.
const PATIENCE: Duration = Duration::from_secs(20);

/// The report of a log that was compared, and the log.
struct Report {
    browser: Browser,
    /// Time, s, and roll, deg, of the log's rows.
    roll: Vec<[f64; 2]>,
    _folder: TempDir,
}

/// A plot's drawing area in the window, px.
struct Area {
    left: f64,
    top: f64,
    width: f64,
    height: f64,
}

impl Area {
    /// A place in it, from its left end at 0 to its right end at 1, half way up.
    fn at(&self, share: f64) -> [f64; 2] {
        [self.left + share * self.width, self.top + 0.5 * self.height]
    }
}

impl Report {
    fn open() -> Result<Report> {
        let folder = tempfile::tempdir()?;
        let duration = DURATION_S.to_string();
        let log = Page::synthetic(folder.path(), "log.csv", &["--duration", &duration, "--rate", "100"])?;
        let compare = ["compare", "log.csv", "--controller", "pid", "--controller", "mpc", "--report", "report.html"];
        Page::sil(folder.path(), &compare)?.map_err(anyhow::Error::msg)?;
        let browser = Browser::start(1280, 900, false)?;
        browser.open(&format!("file://{}", folder.path().join("report.html").display()))?;
        Ok(Report { browser, roll: roll(&fs::read_to_string(log)?)?, _folder: folder })
    }

    fn value(&self, expression: &str) -> Result<Value> {
        self.browser.script(&format!("return {expression}"), &[])
    }

    /// The live plot of this title, scrolled to the middle of the window.
    fn plot(&self, title: &str) -> Result<Area> {
        let script = "const chart = [...document.querySelectorAll('.chart')].find((chart) =>
                chart.closest('[data-figure]').textContent.includes(arguments[0]));
            chart.scrollIntoView({ block: 'center' });
            const over = chart.querySelector('.u-over');
            if (!over) return null;
            const { left, top, width, height } = over.getBoundingClientRect();
            return [left, top, width, height];";
        let begun = Instant::now();
        while begun.elapsed() < PATIENCE {
            if let Value::Array(sizes) = self.browser.script(script, &[json!(title)])? {
                let sizes: Vec<f64> = sizes.iter().filter_map(Value::as_f64).collect();
                let [left, top, width, height] = sizes[..] else { break };
                return Ok(Area { left, top, width, height });
            }
            std::thread::sleep(Duration::from_millis(50));
        }
        anyhow::bail!("no live plot {title}")
    }

    /// What stands beside the cursor at a place of a plot, line by line; empty where nothing does.
    fn values_at(&self, title: &str, share: f64) -> Result<Vec<String>> {
        let area = self.plot(title)?;
        self.browser.mouse(&[Mouse::To(area.at(share)), Mouse::To(area.at(share))])?;
        let script = "const chart = [...document.querySelectorAll('.chart')].find((chart) =>
                chart.closest('[data-figure]').textContent.includes(arguments[0]));
            const box = chart.querySelector('.hover');
            return box.hidden ? [] : [...box.children].map((line) => line.textContent.replace('\u{2212}', '-'));";
        let lines = self.browser.script(script, &[json!(title)])?;
        Ok(lines.as_array().context("no lines")?.iter().filter_map(Value::as_str).map(str::to_owned).collect())
    }

    /// The time under the cursor there, s.
    fn time_at(&self, title: &str, share: f64) -> Result<f64> {
        let lines = self.values_at(title, share)?;
        number(lines.first().context("no time")?)
    }

    /// The logged roll at a time, deg.
    fn logged_roll(&self, time_s: f64) -> Result<f64> {
        let row = self.roll.iter().find(|[at_s, _]| *at_s >= time_s).context("no such time")?;
        Ok(row[1])
    }
}

/// Times and roll angles of a log's rows.
fn roll(text: &str) -> Result<Vec<[f64; 2]>> {
    let mut lines = text.lines().filter(|line| !line.starts_with('#'));
    let header: Vec<&str> = lines.next().context("no header")?.split(',').collect();
    let place = header.iter().position(|name| *name == "roll_rad").context("no roll_rad")?;
    ensure!(header[0] == "time_s");
    let row = |line: &str| {
        let fields: Vec<&str> = line.split(',').collect();
        Ok([fields[0].parse()?, fields[place].parse::<f64>()?.to_degrees()])
    };
    lines.map(row).collect()
}

/// The first number of a line.
fn number(line: &str) -> Result<f64> {
    let word = line.split([' ', ':']).find(|word| word.parse::<f64>().is_ok());
    Ok(word.with_context(|| format!("no number in {line}"))?.parse()?)
}

const ROLL: &str = "Roll angle";
const PITCH: &str = "Pitch angle";

#[test]
fn the_cursor_shows_what_the_log_has_there() -> Result<()> {
    let report = Report::open()?;
    for share in [0.2, 0.5, 0.8] {
        let lines = report.values_at(ROLL, share)?;
        let time_s = number(&lines[0])?;
        assert!((time_s - share * DURATION_S).abs() < 0.02 * DURATION_S, "{lines:?}");
        let measured = lines.iter().find(|line| line.starts_with("measured: ")).context("no measured")?;
        // a step of 20 degrees takes some rows
        let logged = report.logged_roll(time_s)?;
        assert!((number(measured)? - logged).abs() < 1.0, "{lines:?}, {logged}");
        for simulated in ["pid, simulated: ", "mpc, simulated: "] {
            assert!(lines.iter().any(|line| line.starts_with(simulated)), "{lines:?}");
        }
    }
    Ok(())
}

#[test]
fn a_zoomed_plot_takes_the_others_of_its_span_with_it() -> Result<()> {
    let report = Report::open()?;
    let whole_s = [report.time_at(PITCH, 0.02)?, report.time_at(PITCH, 0.98)?];
    assert!(whole_s[1] - whole_s[0] > 0.9 * DURATION_S, "{whole_s:?}");
    let area = report.plot(ROLL)?;
    report.browser.mouse(&[Mouse::To(area.at(0.3)), Mouse::Down, Mouse::To(area.at(0.4)), Mouse::To(area.at(0.5))])?;
    report.browser.mouse(&[Mouse::Up])?;
    for title in [ROLL, PITCH] {
        let shown_s = [report.time_at(title, 0.02)?, report.time_at(title, 0.98)?];
        let expected_s = [0.3 * DURATION_S, 0.5 * DURATION_S];
        for (shown_s, expected_s) in shown_s.into_iter().zip(expected_s) {
            assert!((shown_s - expected_s).abs() < 0.03 * DURATION_S, "{title}: {shown_s} for {expected_s}");
        }
    }
    // a double click shows all again, in the other plot too
    let area = report.plot(ROLL)?;
    let click = [Mouse::Down, Mouse::Up];
    report.browser.mouse(&[&[Mouse::To(area.at(0.5))][..], &click, &click].concat())?;
    let again_s = [report.time_at(PITCH, 0.02)?, report.time_at(PITCH, 0.98)?];
    assert!(again_s[1] - again_s[0] > 0.9 * DURATION_S, "{again_s:?}");
    Ok(())
}

#[test]
fn a_legend_entry_hides_its_curve_and_shows_it_again() -> Result<()> {
    let report = Report::open()?;
    report.plot(ROLL)?;
    let click = "[...document.querySelectorAll('[data-figure]')].find((of) => of.textContent.includes('Roll angle'))
        .querySelector(\".legend [data-name='mpc, simulated']\").click()";
    let has_curve = |report: &Report| -> Result<bool> {
        Ok(report.values_at(ROLL, 0.5)?.iter().any(|line| line.starts_with("mpc, simulated: ")))
    };
    assert!(has_curve(&report)?);
    report.value(click)?;
    assert!(!has_curve(&report)?, "it is still shown");
    assert!(report.values_at(ROLL, 0.5)?.iter().any(|line| line.starts_with("measured: ")), "so are the others");
    report.value(click)?;
    assert!(has_curve(&report)?);
    let complaints = report.browser.log("browser")?;
    assert!(complaints.is_empty(), "{complaints:?}");
    Ok(())
}
