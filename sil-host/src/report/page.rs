//! The page: headline, lead, one picture and a card, sections of text, charts and tables, and where it all comes from.
//!
//! `maud` escapes all text and attributes; what it does not escape are this module's own style sheets and scripts.

use super::bars::Bars;
use super::card::Card;
use super::chart::Chart;
use super::figure;
use super::palette::Palette;
use super::table::Table;
use maud::{DOCTYPE, Markup, PreEscaped, html};

const STYLE: &str = include_str!("style.css");

/// The plotting library with its licence, and what feeds it from the drawings.
const UPLOT: &str = include_str!("uplot/uPlot.iife.min.js");
const UPLOT_STYLE: &str = include_str!("uplot/uPlot.min.css");
const UPLOT_LICENCE: &str = include_str!("uplot/LICENSE");
const PLOTS: &str = include_str!("plots.js");

/// Fewer sections need no list of contents.
const LEAST_SECTIONS_WITH_CONTENTS: usize = 3;

/// A report, to be written to one HTML file.
#[derive(Clone, Debug)]
pub struct Page {
    title: String,
    about: String,
    lead: Vec<String>,
    card: Option<Card>,
    picture: Option<Chart>,
    sections: Vec<Section>,
    provenance: Vec<(String, String)>,
}

/// A part of the page under its own heading; shows its content in the order of the calls.
#[derive(Clone, Debug)]
pub struct Section {
    title: String,
    is_folded: bool,
    blocks: Vec<Block>,
}

#[derive(Clone, Debug)]
enum Block {
    Paragraph(String),
    List(Vec<String>),
    Code(String),
    Note(String),
    Warning(String),
    Chart(Chart),
    SmallMultiples { caption: String, charts: Vec<Chart> },
    SideBySide { caption: String, charts: Vec<Chart> },
    Bars(Bars),
    Card(Card),
    Table(Table),
}

impl Page {
    /// A page without content; its title is its headline: what came out, in a sentence.
    pub fn new(title: impl Into<String>) -> Self {
        Self {
            title: title.into(),
            about: String::new(),
            lead: Vec::new(),
            card: None,
            picture: None,
            sections: Vec::new(),
            provenance: Vec::new(),
        }
    }

    /// Says above the headline what the page is about: which log, which flight.
    pub fn about(self, text: impl Into<String>) -> Self {
        Self { about: text.into(), ..self }
    }

    /// Puts the answer in named lines beside the picture.
    pub fn card(self, card: Card) -> Self {
        Self { card: Some(card), ..self }
    }

    /// The one picture that shows it, on the first screen.
    pub fn picture(self, chart: Chart) -> Self {
        Self { picture: Some(chart), ..self }
    }

    /// Adds a paragraph below the headline.
    pub fn lead(mut self, text: impl Into<String>) -> Self {
        self.lead.push(text.into());
        self
    }

    /// Adds a section.
    pub fn section(mut self, section: Section) -> Self {
        self.sections.push(section);
        self
    }

    /// Adds a line to the footer, such as "Seed", "1": what someone needs to make this page again.
    pub fn provenance(mut self, name: impl Into<String>, value: impl Into<String>) -> Self {
        self.provenance.push((name.into(), value.into()));
        self
    }

    /// The whole file: style, drawings and scripts inside, no reference to anything outside. Without scripts all of it
    /// can be read too.
    pub fn to_html(&self) -> String {
        let page = html! {
            (DOCTYPE)
            html lang="en" {
                head {
                    meta charset="utf-8";
                    meta name="viewport" content="width=device-width, initial-scale=1";
                    meta name="color-scheme" content="light dark";
                    title { (self.title) }
                    style { (PreEscaped(STYLE)) (PreEscaped(UPLOT_STYLE)) }
                }
                body {
                    (self.content())
                    (scripts())
                }
            }
        };
        page.into_string()
    }

    /// What stands in the file's body, without style and scripts, for a document that has them already.
    pub fn to_fragment(&self) -> String {
        self.content().into_string()
    }

    fn content(&self) -> Markup {
        let mut palette = Palette::default();
        html! {
            header {
                @if !self.about.is_empty() { p.about { (self.about) } }
                h1 { (self.title) }
                @for text in &self.lead { p.lead { (text) } }
                (self.first_screen(&mut palette))
            }
            (self.contents())
            main {
                @for (index, section) in self.sections.iter().enumerate() {
                    (section.render(&format!("section-{}", index + 1), &mut palette))
                }
            }
            (self.footer())
        }
    }

    fn first_screen(&self, palette: &mut Palette) -> Markup {
        html! {
            @if self.card.is_some() || self.picture.is_some() {
                div.answer {
                    @if let Some(chart) = &self.picture { (figure::single(chart, palette)) }
                    @if let Some(card) = &self.card { (card.render()) }
                }
            }
        }
    }

    fn contents(&self) -> Markup {
        html! {
            @if self.sections.len() >= LEAST_SECTIONS_WITH_CONTENTS {
                nav aria-label="Contents" {
                    ol {
                        @for (index, section) in self.sections.iter().enumerate() {
                            li { a href=(format!("#section-{}", index + 1)) { (section.title) } }
                        }
                    }
                }
            }
        }
    }

    fn footer(&self) -> Markup {
        html! {
            @if !self.provenance.is_empty() {
                footer {
                    dl {
                        @for (name, value) in &self.provenance {
                            dt { (name) }
                            dd { code { (value) } }
                        }
                    }
                }
            }
        }
    }
}

fn scripts() -> Markup {
    html! { script { (PreEscaped(format!("/*\nuPlot: {UPLOT_LICENCE}*/\n{UPLOT}\n{PLOTS}"))) } }
}

impl Section {
    /// A section without content.
    pub fn new(title: impl Into<String>) -> Self {
        Self { title: title.into(), is_folded: false, blocks: Vec::new() }
    }

    /// Shows its heading alone until the reader opens it: details, evidence.
    pub fn folded(self) -> Self {
        Self { is_folded: true, ..self }
    }

    /// Adds a paragraph.
    pub fn paragraph(self, text: impl Into<String>) -> Self {
        self.with(Block::Paragraph(text.into()))
    }

    /// Adds a list.
    pub fn list<T: Into<String>>(self, items: impl IntoIterator<Item = T>) -> Self {
        self.with(Block::List(items.into_iter().map(Into::into).collect()))
    }

    /// Adds lines as they are typed or printed, such as a command to try.
    pub fn code(self, text: impl Into<String>) -> Self {
        self.with(Block::Code(text.into()))
    }

    /// Adds a remark beside the main text.
    pub fn note(self, text: impl Into<String>) -> Self {
        self.with(Block::Note(text.into()))
    }

    /// Adds something that the reader must not miss.
    pub fn warning(self, text: impl Into<String>) -> Self {
        self.with(Block::Warning(text.into()))
    }

    /// Adds a chart.
    pub fn chart(self, chart: Chart) -> Self {
        self.with(Block::Chart(chart))
    }

    /// Adds small charts with the same axes and one legend, such as one for each motor.
    pub fn small_multiples(self, caption: impl Into<String>, charts: impl IntoIterator<Item = Chart>) -> Self {
        self.with(Block::SmallMultiples { caption: caption.into(), charts: charts.into_iter().collect() })
    }

    /// Adds small charts with axes of their own and one legend, such as one quantity over several others.
    pub fn side_by_side(self, caption: impl Into<String>, charts: impl IntoIterator<Item = Chart>) -> Self {
        self.with(Block::SideBySide { caption: caption.into(), charts: charts.into_iter().collect() })
    }

    /// Adds a ranking.
    pub fn bars(self, bars: Bars) -> Self {
        self.with(Block::Bars(bars))
    }

    /// Adds an answer in named lines, where a page has several.
    pub fn card(self, card: Card) -> Self {
        self.with(Block::Card(card))
    }

    /// Adds a table.
    pub fn table(self, table: Table) -> Self {
        self.with(Block::Table(table))
    }

    fn with(mut self, block: Block) -> Self {
        self.blocks.push(block);
        self
    }

    /// A browser opens a fold for a link to what lies inside of it: the identifier stands there.
    fn render(&self, id: &str, palette: &mut Palette) -> Markup {
        let content = html! { @for block in &self.blocks { (block.render(palette)) } };
        html! {
            @if self.is_folded {
                section.folded {
                    details { summary { h2 { (self.title) } } div id=(id) { (content) } }
                }
            } @else {
                section id=(id) { h2 { (self.title) } (content) }
            }
        }
    }
}

impl Block {
    fn render(&self, palette: &mut Palette) -> Markup {
        match self {
            Self::Paragraph(text) => html! { p { (text) } },
            Self::List(items) => html! { ul { @for item in items { li { (item) } } } },
            Self::Code(text) => html! { pre tabindex="0" { code { (text) } } },
            Self::Note(text) => html! { p.note { strong { "Note: " } (text) } },
            Self::Warning(text) => html! { p.warning { strong { "Warning: " } (text) } },
            Self::Chart(chart) => figure::single(chart, palette),
            Self::SmallMultiples { caption, charts } => figure::small_multiples(caption, charts, palette),
            Self::SideBySide { caption, charts } => figure::side_by_side(caption, charts, palette),
            Self::Bars(bars) => bars.render(),
            Self::Card(card) => card.render(),
            Self::Table(table) => table.render(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::card::Tone;
    use super::super::table::{Better, Cell};
    use super::*;

    /// The page as XML: its only elements without an end tag are the `meta`s, which are left out.
    fn as_xml(html: &str) -> String {
        let html = &without_scripts(html);
        let (doctype, rest) = html.split_at("<!DOCTYPE html>".len());
        assert_eq!(doctype, "<!DOCTYPE html>");
        let mut parts = rest.split("<meta ");
        let mut xml = parts.next().unwrap_or_default().to_owned();
        for part in parts {
            xml.push_str(part.split_once('>').map_or("", |(_, after)| after));
        }
        xml
    }

    /// The page without the one script that every page has.
    fn without_scripts(html: &str) -> String {
        let script = scripts().into_string();
        assert_eq!(html.matches(&script).count(), 1);
        html.replace(&script, "")
    }

    /// One of everything, with this text wherever text goes.
    fn page_saying(text: &str) -> Page {
        let chart = Chart::time_series(text, text)
            .caption(text)
            .series(text, &[0.0, 1.0], &[2.0, 3.0])
            .step_series(text, &[0.0, 1.0], &[2.0, 2.5])
            .span(0.2, 0.4, text);
        let section = Section::new(text)
            .paragraph(text)
            .list([text, text])
            .code(text)
            .note(text)
            .warning(text)
            .chart(chart.clone())
            .small_multiples(text, [chart.clone(), chart.clone()])
            .side_by_side(text, [Chart::over(text, text, text).series(text, &[0.0, 1.0], &[2.0, 3.0]), chart.clone()])
            .bars(Bars::new(text).bar(text, 30.0, Some([20.0, 40.0])).rest(text, 70.0))
            .card(Card::new(Tone::Bad).line(text, text))
            .table(
                Table::new(text, &[text, "PID", "MPC"])
                    .comparison(text, &[1.0, 2.0], 1, Better::Lower)
                    .row([Cell::to_section(text, 1)]),
            );
        let page = Page::new(text).about(text).lead(text).picture(chart).provenance(text, text);
        let page = page.card(Card::new(Tone::Doubtful).line(text, text));
        page.section(section.clone()).section(section.clone().folded()).section(section)
    }

    /// All elements with their attributes and texts.
    fn content(html: &str) -> Vec<String> {
        let xml = as_xml(html);
        let document = roxmltree::Document::parse(&xml).expect("well-formed");
        let describe = |node: roxmltree::Node<'_, '_>| {
            let attributes: Vec<String> = node.attributes().map(|of| format!("{}={}", of.name(), of.value())).collect();
            format!("<{} {}> {}", node.tag_name().name(), attributes.join(" "), node.text().unwrap_or_default())
        };
        document.descendants().map(describe).collect()
    }

    #[test]
    fn all_text_is_escaped() {
        let hostile = r#"</style><script>alert("1 & 2")</script>'<!--"#;
        let html = without_scripts(&page_saying(hostile).to_html());
        assert!(!html.contains("<script") && !html.contains("<!--"));
        // The reader sees the very text, and around it what surrounds any other text.
        let plain: Vec<String> =
            content(&page_saying("PLAIN").to_html()).iter().map(|line| line.replace("PLAIN", hostile)).collect();
        assert_eq!(content(&page_saying(hostile).to_html()), plain);
    }

    #[test]
    fn the_file_refers_to_nothing_outside() {
        let html = without_scripts(&page_saying("text").to_html());
        for reference in ["http", "//", "url(", "@import", "src=", "<link", "<script"] {
            assert!(!html.contains(reference), "{reference}");
        }
        // the library's script has its own address in a comment and nothing else
        let script = scripts().into_string();
        assert_eq!(script.matches("//").count() - PLOTS.matches("//").count(), 1);
        for word in ["fetch(", "XMLHttpRequest", "import(", "WebSocket", "sendBeacon", "eval("] {
            assert!(!script.contains(word), "{word}");
        }
        let links = html.matches("href=").count();
        assert_eq!(html.matches("href=\"#section-").count(), links, "links lead to the page's own sections");
    }

    #[test]
    fn every_drawing_has_a_text_and_every_table_its_headers() {
        let xml = as_xml(&page_saying("text").to_html());
        let document = roxmltree::Document::parse(&xml).expect("well-formed");
        let elements = |name: &'static str| document.descendants().filter(move |node| node.has_tag_name(name));
        for svg in elements("svg").filter(|svg| !svg.ancestors().skip(1).any(|outer| outer.has_tag_name("svg"))) {
            assert!(svg.attribute("aria-label").is_some() || svg.attribute("aria-hidden") == Some("true"));
        }
        assert!(elements("th").all(|header| header.attribute("scope").is_some()));
        assert!(elements("table").all(|table| table.attribute("aria-label").is_some()));
        assert_eq!(elements("h1").count(), 1);
    }

    #[test]
    fn every_class_is_in_the_style_sheet() {
        let xml = as_xml(&page_saying("text").to_html());
        let document = roxmltree::Document::parse(&xml).expect("well-formed");
        let used = document.descendants().filter_map(|node| node.attribute("class")).flat_map(str::split_whitespace);
        for class in used.filter(|&class| class != "text" && class != "dash0") {
            assert!(STYLE.contains(&format!(".{class}")), "{class}");
        }
    }

    /// As large as the demonstration's page: 8 charts of three curves with 12,000 samples each, and all of it noise.
    fn noisy_page() -> Page {
        let time_s: Vec<f64> = (0..12_000).map(|index| f64::from(index) / 400.0).collect();
        let noise = |seed: f64| -> Vec<f64> {
            time_s.iter().map(|time_s| (43_758.545 * libm::sin(5_195.9 * time_s + seed)).fract()).collect()
        };
        let chart = |index: u32| {
            ["a", "b", "c"]
                .into_iter()
                .zip([0.1, 0.2, 0.3])
                .fold(Chart::time_series("Noise", "deg"), |chart, (name, seed)| {
                    chart.series(name, &time_s, &noise(f64::from(index) + seed))
                })
        };
        Page::new("Noise").section((0..8).map(chart).fold(Section::new("Charts"), Section::chart))
    }

    #[test]
    fn the_same_calls_give_the_same_bytes_and_not_too_many() {
        let html = noisy_page().to_html();
        assert_eq!(html, noisy_page().to_html());
        assert!(html.len() < 1_500_000, "{} bytes", html.len());
    }
}
