//! Who may call whom in the linked image, read from its instructions.
//!
//! Direct calls and branches are what they say. A call through a register or memory may go to every function whose
//! address occurs anywhere: as a word in read-only or initialised data or between instructions, or built by `movw` and
//! `movt`. So the graph has every call that can happen, and some that can't.

use std::collections::{BTreeMap, BTreeSet, VecDeque};
use std::fmt;
use std::ops::Range;

use anyhow::{Context, Result, bail};
use object::read::elf::ElfFile32;
use object::{LittleEndian, Object, ObjectSection, ObjectSymbol, SectionKind, SymbolKind};

use crate::thumb::{self, Effect};

/// Index of a function.
pub(crate) type FunctionId = usize;

/// What lies between two mapping symbols (ELF for the Arm Architecture, AAELF32, 5.5.5).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Content {
    Instructions,
    Data,
}

/// The section of code.
struct Text<'a> {
    base: u32,
    bytes: &'a [u8],
    /// Where instructions and data begin, in the order of addresses.
    contents: Vec<(u32, Content)>,
}

struct Function {
    name: String,
    start: u32,
    end: u32,
    /// Where it calls or branches from, by whom it reaches.
    calls: BTreeMap<FunctionId, u32>,
    /// Where it first calls through a pointer.
    calls_pointer_at: Option<u32>,
}

impl Function {
    fn new(name: String, start: u32, end: u32) -> Self {
        Self { name, start, end, calls: BTreeMap::new(), calls_pointer_at: None }
    }
}

/// The functions of an image and their calls.
pub(crate) struct CallGraph {
    /// In the order of their addresses.
    functions: Vec<Function>,
    /// Those whose address occurs somewhere.
    pointed_to: BTreeSet<FunctionId>,
}

/// One call of a path.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Call {
    pub(crate) caller: FunctionId,
    pub(crate) callee: FunctionId,
    /// Address of the instruction.
    pub(crate) at: u32,
    /// Through a pointer, so that it may or may not go there.
    pub(crate) through_pointer: bool,
}

/// How the functions that can be reached from somewhere are reached: the last call of a shortest path to each.
pub(crate) struct Reach(BTreeMap<FunctionId, Option<Call>>);

impl CallGraph {
    /// Reads the image.
    pub(crate) fn of_image(file: &ElfFile32<'_, LittleEndian>) -> Result<Self> {
        let section = file.section_by_name(".text").context("no section .text")?;
        let text = Text { base: section.address() as u32, bytes: section.data()?, contents: contents(file)? };
        let mut words = Vec::new();
        let kinds = [SectionKind::Data, SectionKind::ReadOnlyData, SectionKind::ReadOnlyString];
        for section in file.sections().filter(|section| kinds.contains(&section.kind())) {
            // nobody calls through the vector table
            if section.name()? != ".vector_table" {
                words.extend(section.data()?.chunks_exact(4).map(word_of));
            }
        }
        Self::new(functions(file, &text), &text, words)
    }

    /// `words` are the data outside of the code.
    fn new(functions: Vec<Function>, text: &Text, words: impl IntoIterator<Item = u32>) -> Result<Self> {
        let mut graph = Self { functions, pointed_to: BTreeSet::new() };
        for id in 0..graph.functions.len() {
            graph.read_function(id, text)?;
        }
        graph.read_gaps(text)?;
        words.into_iter().for_each(|word| graph.note_pointer(word));
        Ok(graph)
    }

    /// Functions of nothing but instructions, one behind the other.
    #[cfg(test)]
    pub(crate) fn of_code(functions: &[(&str, &[u16])]) -> Self {
        tests::graph(functions, &[]).unwrap()
    }

    /// The function that has this address inside.
    pub(crate) fn at(&self, address: u32) -> Option<FunctionId> {
        let after = self.functions.partition_point(|function| function.start <= address);
        let id = after.checked_sub(1)?;
        (address < self.functions[id].end).then_some(id)
    }

    /// All functions with such a name.
    pub(crate) fn named(&self, wanted: impl Fn(&str) -> bool) -> BTreeSet<FunctionId> {
        let functions = self.functions.iter().enumerate();
        functions.filter(|(_, function)| wanted(&function.name)).map(|(id, _)| id).collect()
    }

    /// A name as in the source, with path.
    pub(crate) fn name(&self, id: FunctionId) -> &str {
        &self.functions[id].name
    }

    /// How many functions there are.
    pub(crate) fn len(&self) -> usize {
        self.functions.len()
    }

    /// All calls of a function, those through pointers to all that they may reach.
    pub(crate) fn calls(&self, caller: FunctionId) -> impl Iterator<Item = Call> {
        let function = &self.functions[caller];
        let direct = function.calls.iter();
        let direct = direct.map(move |(callee, at)| Call { caller, callee: *callee, at: *at, through_pointer: false });
        let pointers = function.calls_pointer_at.into_iter().flat_map(move |at| {
            self.pointed_to.iter().map(move |callee| Call { caller, callee: *callee, at, through_pointer: true })
        });
        direct.chain(pointers)
    }

    /// What can be reached from these, over the calls that `counts`.
    pub(crate) fn reach(&self, roots: impl IntoIterator<Item = FunctionId>, counts: impl Fn(&Call) -> bool) -> Reach {
        let mut reached: BTreeMap<_, _> = roots.into_iter().map(|root| (root, None)).collect();
        let mut open: VecDeque<_> = reached.keys().copied().collect();
        while let Some(caller) = open.pop_front() {
            for call in self.calls(caller).filter(&counts) {
                reached.entry(call.callee).or_insert_with(|| {
                    open.push_back(call.callee);
                    Some(call)
                });
            }
        }
        Reach(reached)
    }

    /// A path in words, a line a call.
    pub(crate) fn shown<'a>(&'a self, path: &'a [Call]) -> impl fmt::Display + 'a {
        fmt::from_fn(move |f| {
            for call in path {
                let how = if call.through_pointer { ", which calls through a pointer" } else { "" };
                write!(f, "\n    {}{how} at {:#010x}", self.name(call.caller), call.at)?;
            }
            path.last().map_or(Ok(()), |call| write!(f, "\n    {}", self.name(call.callee)))
        })
    }

    fn read_function(&mut self, id: FunctionId, text: &Text) -> Result<()> {
        let (mut address, end) = (self.functions[id].start, self.functions[id].end);
        while address < end {
            let (content, stop) = text.content_at(address)?;
            let stop = stop.min(end);
            match content {
                Content::Instructions => self.read_instructions(id, address..stop, text)?,
                Content::Data => self.read_words(address..stop, text),
            }
            address = stop;
        }
        Ok(())
    }

    fn read_instructions(&mut self, id: FunctionId, addresses: Range<u32>, text: &Text) -> Result<()> {
        // halves of addresses that movw has put into registers
        let mut low = [0; 16];
        let mut at = addresses.start;
        while at < addresses.end {
            let (first, second) = (text.half(at), text.half(at + 2));
            match thumb::effect(at, first, second) {
                Effect::None => {}
                Effect::Branch(target) => self.note_branch(id, at, target)?,
                Effect::Indirect => {
                    self.functions[id].calls_pointer_at.get_or_insert(at);
                }
                Effect::SetLow { register, half } => low[usize::from(register)] = u32::from(half),
                Effect::SetHigh { register, half } => {
                    self.note_pointer(low[usize::from(register)] | u32::from(half) << 16);
                }
            }
            at += if thumb::is_wide(first) { 4 } else { 2 };
        }
        Ok(())
    }

    fn note_branch(&mut self, caller: FunctionId, at: u32, target: u32) -> Result<()> {
        let Some(callee) = self.at(target) else {
            bail!("{} at {at:#010x} goes to {target:#010x}, where no function is", self.name(caller));
        };
        if callee != caller {
            self.functions[caller].calls.entry(callee).or_insert(at);
        }
        Ok(())
    }

    /// A word that may be a function's address: such have their lowest bit set, for Thumb.
    fn note_pointer(&mut self, word: u32) {
        if word & 1 != 0
            && let Some(id) = self.at(word & !1)
            && self.functions[id].start == word & !1
        {
            self.pointed_to.insert(id);
        }
    }

    /// Between functions lie literals and what the linker fills with. Else there is code that nobody has looked at.
    fn read_gaps(&mut self, text: &Text) -> Result<()> {
        let end_of_text = text.base + text.bytes.len() as u32;
        let starts = self.functions.iter().map(|function| function.start).chain([end_of_text]);
        let ends = [text.base].into_iter().chain(self.functions.iter().map(|function| function.end));
        for (mut at, start) in ends.zip(starts).collect::<Vec<_>>() {
            while at < start {
                let (content, stop) = text.content_at(at)?;
                let stop = stop.min(start);
                if content == Content::Data {
                    self.read_words(at..stop, text);
                } else if stop - at >= 4 && (at..stop).any(|at| !matches!(text.byte(at), 0 | 0xd4)) {
                    bail!("code at {at:#010x} belongs to no function");
                }
                at = stop;
            }
        }
        Ok(())
    }

    fn read_words(&mut self, addresses: Range<u32>, text: &Text) {
        let words = (addresses.start.next_multiple_of(4)..addresses.end).step_by(4);
        words.for_each(|at| self.note_pointer(text.word(at)));
    }
}

impl Text<'_> {
    fn byte(&self, at: u32) -> u8 {
        let offset = at.checked_sub(self.base).map(|offset| offset as usize);
        offset.and_then(|offset| self.bytes.get(offset)).copied().unwrap_or_default()
    }

    fn half(&self, at: u32) -> u16 {
        u16::from_le_bytes([self.byte(at), self.byte(at + 1)])
    }

    fn word(&self, at: u32) -> u32 {
        u32::from(self.half(at)) | u32::from(self.half(at + 2)) << 16
    }

    /// What lies there, and up to where.
    fn content_at(&self, at: u32) -> Result<(Content, u32)> {
        let next = self.contents.partition_point(|(start, _)| *start <= at);
        let last = next.checked_sub(1).and_then(|last| self.contents.get(last));
        let (_, content) = last.with_context(|| format!("no mapping symbol before {at:#010x}"))?;
        Ok((*content, self.contents.get(next).map_or(u32::MAX, |(start, _)| *start)))
    }
}

impl Reach {
    /// The functions reached, those at which it began included.
    pub(crate) fn functions(&self) -> impl Iterator<Item = FunctionId> {
        self.0.keys().copied()
    }

    /// A shortest path; empty to where it began, none to where it does not come.
    pub(crate) fn path_to(&self, function: FunctionId) -> Option<Vec<Call>> {
        let mut path = Vec::new();
        let mut last = self.0.get(&function)?;
        while let Some(call) = last {
            path.push(*call);
            last = self.0.get(&call.caller)?;
        }
        path.reverse();
        Some(path)
    }
}

/// One entry an address: functions of equal code share theirs, under the first name.
fn functions(file: &ElfFile32<'_, LittleEndian>, text: &Text) -> Vec<Function> {
    let mut by_start = BTreeMap::<u32, Function>::new();
    for symbol in file.symbols().filter(|symbol| symbol.kind() == SymbolKind::Text && symbol.size() > 0) {
        let start = symbol.address() as u32 & !1;
        let end = start + symbol.size() as u32;
        if start < text.base || end > text.base + text.bytes.len() as u32 {
            continue;
        }
        let name = format!("{:#}", rustc_demangle::demangle(symbol.name().unwrap_or_default()));
        let known = by_start.entry(start).or_insert_with(|| Function::new(name, start, end));
        known.end = known.end.max(end);
    }
    by_start.into_values().collect()
}

/// Where instructions and data begin.
fn contents(file: &ElfFile32<'_, LittleEndian>) -> Result<Vec<(u32, Content)>> {
    let mut contents = Vec::new();
    for symbol in file.symbols() {
        let content = match symbol.name()?.split('.').next() {
            Some("$t") => Content::Instructions,
            Some("$d") => Content::Data,
            _ => continue,
        };
        contents.push((symbol.address() as u32, content));
    }
    contents.sort_by_key(|(address, _)| *address);
    Ok(contents)
}

fn word_of(bytes: &[u8]) -> u32 {
    bytes.iter().rev().fold(0, |word, byte| word << 8 | u32::from(*byte))
}

#[cfg(test)]
mod tests {
    use super::*;

    const BASE: u32 = 0x0800_4000;

    /// Functions of given lengths in half-words, one behind the other, all instructions.
    pub(super) fn graph(functions: &[(&str, &[u16])], words: &[u32]) -> Result<CallGraph> {
        let mut at = BASE;
        let mut listed = Vec::new();
        for (name, code) in functions {
            let end = at + 2 * code.len() as u32;
            listed.push(Function::new((*name).to_owned(), at, end));
            at = end;
        }
        let halves = functions.iter().flat_map(|(_, code)| code.iter());
        let bytes = halves.flat_map(|half| half.to_le_bytes()).collect::<Vec<_>>();
        let text = Text { base: BASE, bytes: &bytes, contents: vec![(BASE, Content::Instructions)] };
        CallGraph::new(listed, &text, words.iter().copied())
    }

    fn path(graph: &CallGraph, from: &str, to: &str) -> Option<Vec<String>> {
        let reach = graph.reach(graph.named(|name| name == from), |_| true);
        let path = reach.path_to(*graph.named(|name| name == to).first()?)?;
        Some(path.iter().map(|call| graph.name(call.callee).to_owned()).collect())
    }

    const BX_LR: u16 = 0x4770;
    const BLX_R3: u16 = 0x4798;

    #[test]
    fn calls_and_tail_branches_are_followed() {
        // task: bl +4 -> helper; helper: b .+4 -> last; alone: nobody calls it
        let graph = graph(
            &[
                ("task", &[0xf000, 0xf801, BX_LR]),
                ("helper", &[0xe000, BX_LR]),
                ("last", &[BX_LR]),
                ("alone", &[BX_LR]),
            ],
            &[],
        )
        .unwrap();
        assert_eq!(path(&graph, "task", "last").unwrap(), ["helper", "last"]);
        assert_eq!(path(&graph, "task", "alone"), None);
        assert_eq!(path(&graph, "last", "task"), None);
    }

    #[test]
    fn a_call_through_a_pointer_may_reach_what_is_pointed_to_and_nothing_else() {
        let functions: [(&str, &[u16]); 4] =
            [("task", &[BLX_R3, BX_LR]), ("other", &[BX_LR]), ("pointed to", &[BX_LR]), ("quiet", &[BX_LR])];
        let pointer = BASE + 6 + 1;
        let with_pointer = graph(&functions, &[pointer]).unwrap();
        assert_eq!(path(&with_pointer, "task", "pointed to").unwrap(), ["pointed to"]);
        assert_eq!(path(&with_pointer, "task", "other"), None);
        assert_eq!(path(&with_pointer, "quiet", "pointed to"), None);
        // without the bit for Thumb, or into the middle of a function, it is a number like any other
        assert_eq!(path(&graph(&functions, &[pointer & !1, BASE + 3]).unwrap(), "task", "pointed to"), None);
    }

    #[test]
    fn an_address_built_in_a_register_is_a_pointer() {
        // movw r3, #0x400b; movt r3, #0x0800; blx r3
        let code = [0xf244, 0x030b, 0xf6c0, 0x0300, BLX_R3];
        let graph = graph(&[("task", &code), ("pointed to", &[BX_LR])], &[]).unwrap();
        assert_eq!(path(&graph, "task", "pointed to").unwrap(), ["pointed to"]);
    }

    #[test]
    fn words_between_instructions_are_pointers_and_no_instructions() {
        // blx r3, return, and a word: the address of `pointed to`
        let bytes = [BLX_R3, BX_LR, 0x4009, 0x0800, BX_LR].map(u16::to_le_bytes).concat();
        let contents =
            vec![(BASE, Content::Instructions), (BASE + 4, Content::Data), (BASE + 8, Content::Instructions)];
        let functions = || {
            vec![
                Function::new("task".to_owned(), BASE, BASE + 8),
                Function::new("pointed to".to_owned(), BASE + 8, BASE + 10),
            ]
        };
        let graph = CallGraph::new(functions(), &Text { base: BASE, bytes: &bytes, contents }, []).unwrap();
        assert_eq!(path(&graph, "task", "pointed to").unwrap(), ["pointed to"]);
        // a jump out of all functions is an error, and so is code without a name
        let contents = vec![(BASE, Content::Instructions)];
        let away = [0xe7f0, BX_LR, BX_LR, BX_LR, BX_LR].map(u16::to_le_bytes).concat();
        assert!(
            CallGraph::new(functions(), &Text { base: BASE, bytes: &away, contents: contents.clone() }, []).is_err()
        );
        let nameless = vec![Function::new("task".to_owned(), BASE, BASE + 2)];
        assert!(CallGraph::new(nameless, &Text { base: BASE, bytes: &bytes, contents }, []).is_err());
    }
}
