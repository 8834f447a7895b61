//! `sil` without arguments.

use crate::sil::{Folder, Outcome};

#[test]
fn it_writes_the_same_report_says_where_and_opens_nothing() {
    let folder = Folder::new();
    let outcome = folder.sil(&[]).assert_done();
    let report = folder.path("out/report.html").canonicalize().unwrap();
    assert!(outcome.stdout.contains(&format!("report  {}\n", report.display())), "{outcome:?}");
    assert!(!outcome.stdout.contains("opening"), "{outcome:?}");
    for text in
        ["pid roll", "mpc pitch", "SYNTHETIC", "closed loop, mean |simulated - measured|", "open-loop prediction"]
    {
        assert!(outcome.stdout.contains(text), "no \"{text}\" in {outcome:?}");
    }
    let page = String::from_utf8(folder.bytes("out/report.html")).unwrap();
    assert!(page.starts_with("<!DOCTYPE html>") && page.trim_end().ends_with("</html>"));
    assert!(page.contains("<svg"));
    // the answer stands before everything else, with the size that the log was made with: 0.2 N m
    let (head, _) = page.split_once("<main>").unwrap();
    assert!(head.contains("<h1>Pitch is out of balance by 0.20\u{a0}N\u{a0}m"), "{head}");
    for part in ["Explained: nothing but noise remains", "measured", "nominal model", "with the findings"] {
        assert!(head.contains(part), "no \"{part}\" on the first screen");
    }
    assert!(page.len() < 2_000_000, "{} bytes", page.len());
    // nothing else is left behind
    let names = |path: &str| std::fs::read_dir(folder.path(path)).unwrap().map(|entry| entry.unwrap().file_name());
    assert_eq!(names("").collect::<Vec<_>>(), ["out"]);
    assert_eq!(names("out").collect::<Vec<_>>(), ["report.html"]);
    // a screen alone, with the output in a pipe where nobody is looking, opens nothing either; the report is the same
    // at every run
    let mut command = folder.command(&[]);
    command.env("DISPLAY", ":0");
    let outcome = Outcome::of(&[], command).assert_done();
    assert!(!outcome.stdout.contains("opening"), "{outcome:?}");
    assert!(String::from_utf8(folder.bytes("out/report.html")).unwrap() == page);
}
