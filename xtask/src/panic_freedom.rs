//! No panic can be reached from what runs after start-up: every interrupt handler, so every task, and the idle loop.
//!
//! Start-up may panic: nothing flies yet. That it can shows at every run that this check finds a panic where there is
//! one.

use std::collections::BTreeSet;
use std::fmt::Write;
use std::fs;
use std::path::Path;

use anyhow::{Context, Result, bail, ensure};
use object::LittleEndian;
use object::read::elf::ElfFile32;
use object::{Object, ObjectSection};

use crate::call_graph::{Call, CallGraph, FunctionId};

/// Entered by start-up when it is done.
const IDLE: &str = "firmware::pixhawk::app::idle";

/// A call of a panic that can't happen, though the compiler can't see why.
struct Exception {
    caller: &'static str,
    callee: &'static str,
    /// Why it can't happen. Nobody checks that by machine, so let there be few.
    proof: &'static str,
}

const EXCEPTIONS: &[Exception] = &[Exception {
    caller: "_defmt_acquire",
    callee: "core::panicking::panic_fmt",
    proof: "defmt-rtt panics if a context that owns the logger takes it again before it gives it back. A context owns \
            it for the length of one message. Within that length runs only defmt's own code, since all that this \
            image puts into messages are integers; a type of ours in a message would have to bring no message of its \
            own.",
}];

/// Where control enters the image, by address.
struct Entries {
    reset: u32,
    /// Handlers of interrupts and faults.
    handlers: Vec<u32>,
}

/// Fails with the way to every panic that can be reached; returns in words what was looked at.
pub(crate) fn check(path: &Path) -> Result<String> {
    let bytes = fs::read(path).with_context(|| format!("cannot read {}", path.display()))?;
    let file = ElfFile32::<LittleEndian>::parse(&*bytes)?;
    let graph = CallGraph::of_image(&file)?;
    let entries = entries(&file)?;
    let function = |address: u32| graph.at(address & !1).with_context(|| format!("no function at {address:#010x}"));
    let mut roots = entries.handlers.into_iter().map(function).collect::<Result<BTreeSet<_>>>()?;
    let idle = graph.named(|name| name == IDLE);
    roots.insert(*idle.first().with_context(|| format!("no function {IDLE}"))?);
    check_graph(&graph, function(entries.reset)?, &roots, EXCEPTIONS)
}

/// The words of the vector table: initial stack pointer, reset, then handlers, and zeros where there is none.
fn entries(file: &ElfFile32<'_, LittleEndian>) -> Result<Entries> {
    let table = file.section_by_name(".vector_table").context("no vector table")?.data()?;
    let mut vectors =
        table.chunks_exact(4).map(|word| u32::from_le_bytes([word[0], word[1], word[2], word[3]])).skip(1);
    let reset = vectors.next().context("no reset vector")?;
    Ok(Entries { reset, handlers: vectors.filter(|address| *address != 0).collect() })
}

fn check_graph(
    graph: &CallGraph,
    reset: FunctionId,
    roots: &BTreeSet<FunctionId>,
    exceptions: &[Exception],
) -> Result<String> {
    let panics = graph.named(is_panic);
    let from_reset = graph.reach([reset], |_| true);
    ensure!(
        from_reset.functions().any(|function| panics.contains(&function)),
        "start-up can panic, but in the call graph it can't: the graph is not complete, or panics have other names"
    );
    let excepted = |call: &Call| {
        let names = (graph.name(call.caller), graph.name(call.callee));
        exceptions.iter().position(|exception| (exception.caller, exception.callee) == names)
    };
    let reach = graph.reach(roots.iter().copied(), |call| !panics.contains(&call.callee));
    let calls = reach.functions().flat_map(|function| graph.calls(function));
    let (allowed, forbidden): (Vec<_>, Vec<_>) =
        calls.filter(|call| panics.contains(&call.callee)).partition(|call| excepted(call).is_some());
    if !forbidden.is_empty() {
        let mut report = "after start-up a panic can be reached:".to_owned();
        for call in forbidden {
            let mut path = reach.path_to(call.caller).unwrap_or_default();
            path.push(call);
            writeln!(report, "{}", graph.shown(&path))?;
        }
        bail!(report);
    }
    let used = allowed.iter().filter_map(excepted).collect::<BTreeSet<_>>();
    let unused = exceptions.iter().enumerate().find(|(index, _)| !used.contains(index));
    if let Some((_, Exception { caller, callee, proof })) = unused {
        bail!("no {caller} calls {callee} any more, so this needs no proof: {proof}");
    }
    Ok(format!(
        "no panic within the {} functions (of {}) that {} handlers and the idle loop reach, {} by proof",
        reach.functions().count(),
        graph.len(),
        roots.len() - 1,
        used.len()
    ))
}

/// Functions of Rust's core library that end in the panic handler, and that handler.
fn is_panic(name: &str) -> bool {
    let last = name.rsplit("::").next().unwrap_or(name);
    let fails = last.contains("panic") || last.ends_with("_fail") || last.ends_with("_failed");
    name.starts_with("core::panicking::") || name.starts_with("core::") && fails || last == "rust_begin_unwind"
}

#[cfg(test)]
mod tests {
    use super::*;

    const BX_LR: u16 = 0x4770;
    /// Calls the function behind it, and returns.
    const CALL_NEXT: [u16; 3] = [0xf000, 0xf801, BX_LR];

    /// Start-up calls a panic, the task calls a helper, and behind the helper lies a panic.
    fn graph(helper: &[u16]) -> CallGraph {
        let code: [(&str, &[u16]); 5] = [
            ("Reset", &CALL_NEXT),
            ("core::option::unwrap_failed", &[BX_LR]),
            ("TIM3", &CALL_NEXT),
            ("helper", helper),
            ("core::panicking::panic_fmt", &[BX_LR]),
        ];
        CallGraph::of_code(&code)
    }

    fn checked(graph: &CallGraph, root: &str, exceptions: &[Exception]) -> Result<String> {
        let named = |wanted: &str| graph.named(|name| name == wanted);
        check_graph(graph, *named("Reset").first().unwrap(), &named(root), exceptions)
    }

    const PROVEN: Exception =
        Exception { caller: "helper", callee: "core::panicking::panic_fmt", proof: "it is a test" };

    #[test]
    fn a_planted_panic_is_found_with_the_way_to_it() {
        let error = checked(&graph(&CALL_NEXT), "TIM3", &[]).unwrap_err().to_string();
        let way = "\n    TIM3 at 0x08004008\n    helper at 0x0800400e\n    core::panicking::panic_fmt\n";
        assert!(error.ends_with(way), "{error}");
        checked(&graph(&[BX_LR]), "TIM3", &[]).unwrap();
    }

    #[test]
    fn a_proof_lifts_one_call_and_must_not_outlive_it() {
        checked(&graph(&CALL_NEXT), "TIM3", &[PROVEN]).unwrap();
        let error = checked(&graph(&[BX_LR]), "TIM3", &[PROVEN]).unwrap_err().to_string();
        assert!(error.ends_with("it is a test"), "{error}");
        checked(&graph(&CALL_NEXT), "Reset", &[PROVEN]).unwrap_err();
    }

    #[test]
    fn a_graph_in_which_start_up_cannot_panic_is_not_believed() {
        let graph = CallGraph::of_code(&[("Reset", &[BX_LR]), ("TIM3", &[BX_LR])]);
        let error = checked(&graph, "TIM3", &[]).unwrap_err().to_string();
        assert!(error.contains("not complete"), "{error}");
    }

    #[test]
    fn panics_are_known_by_name() {
        for name in [
            "core::panicking::panic_const::panic_const_rem_by_zero",
            "core::slice::index::slice_index_fail",
            "core::str::slice_error_fail",
            "core::option::expect_failed",
            "core::cell::panic_already_borrowed",
            "__rustc::rust_begin_unwind",
            "rust_begin_unwind",
        ] {
            assert!(is_panic(name), "{name}");
        }
        for name in ["core::fmt::write", "firmware::pixhawk::fault::stop", "core::str::from_utf8"] {
            assert!(!is_panic(name), "{name}");
        }
    }
}
