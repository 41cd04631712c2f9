//! `sweep script`: a shell script that submits a sweep to SLURM.

use super::file::{self, folder_of};
use crate::answer::Answer;
use crate::arguments::ScriptInput;
use crate::failure::Failure;
use crate::input::Source;
use luenberger_study::execute::{BLOCKS, Plan};
use serde_json::json;
use std::fmt::Write;

/// Shards by default: one for each block, at most these.
const SHARDS: u64 = 100;

pub(super) fn script(input: &ScriptInput) -> Result<Answer, Failure> {
    let Source::File(path) = &input.study else {
        return Err(Failure::Usage("a script needs a study in a file, and not on standard input"));
    };
    let study = file::read(&input.study)?;
    let plan = Plan::of_study(&study, input.block_size)?;
    let shards = input.shards.map_or_else(|| plan.blocks().min(SHARDS), u64::from);
    let root = folder_of(input.output.as_deref(), &input.study);
    let (study, root) = (quoted(&path.to_string_lossy()), root.to_string_lossy().into_owned());
    let logs = format!("{root}/{BLOCKS}");
    let name = path.file_stem().map_or_else(|| "sweep".into(), |stem| stem.to_string_lossy());
    let name: String = name.chars().map(|c| if c.is_ascii_alphanumeric() { c } else { '-' }).collect();
    let options = |line: &mut String, log: &str| {
        let given = [("partition", &input.partition), ("account", &input.account), ("time", &input.time)];
        for (option, value) in given.into_iter().chain([("mem", &input.mem)]) {
            if let Some(value) = value {
                _ = writeln!(line, "#SBATCH --{option}={value}");
            }
        }
        _ = writeln!(line, "#SBATCH --output={}", quoted(&format!("{}/{log}", logs.replace('%', "%%"))));
    };
    let block_size = input.block_size.map(|size| format!(" --block-size {size}")).unwrap_or_default();
    let mut text = format!(
        "#!/bin/sh\n\
         # Submits a sweep of {} runs to SLURM: an array of {shards} shards, and their reduction once all have succeeded.\n\
         # Submitted again after a failure, it computes the blocks that are missing.\n\
         set -eu\n\
         mkdir -p {}\n\
         array=$(sbatch --parsable <<'END'\n\
         #!/bin/sh\n\
         #SBATCH --job-name={name}\n\
         #SBATCH --array=1-{shards}\n\
         #SBATCH --cpus-per-task={}\n\
         #SBATCH --requeue\n",
        plan.runs(),
        quoted(&logs),
        input.cpus,
    );
    options(&mut text, "slurm-shard-%a.txt");
    let root = quoted(&root);
    _ = write!(
        text,
        "luenberger sweep {study} -o {root}{block_size} --shard \"$SLURM_ARRAY_TASK_ID/{shards}\" --threads \
         \"$SLURM_CPUS_PER_TASK\" --limit time=none && exit\n\
         code=$?\n\
         # Killed: once more, up to three times. A job that failed would end the wait for it.\n\
         if [ \"$code\" -gt 128 ] && [ \"${{SLURM_RESTART_COUNT:-0}}\" -lt 3 ]; then\n    \
         scontrol requeue \"${{SLURM_ARRAY_JOB_ID}}_$SLURM_ARRAY_TASK_ID\"\n\
         fi\n\
         exit $code\n\
         END\n)\n\
         sbatch --dependency=\"afterok:${{array%%;*}}\" <<'END'\n\
         #!/bin/sh\n\
         #SBATCH --job-name={name}-reduce\n",
    );
    options(&mut text, "slurm-reduce.txt");
    _ = write!(text, "exec luenberger sweep reduce {root}\nEND\n");
    let json = json!({ "script": text, "shards": shards, "blocks": plan.blocks(), "runs": plan.runs() });
    Ok(Answer::new(text, &json)?)
}

/// A word of a shell command.
fn quoted(word: &str) -> String {
    let is_plain = |c: char| c.is_ascii_alphanumeric() || "_-./%+=:,@".contains(c);
    if !word.is_empty() && word.chars().all(is_plain) {
        return word.to_owned();
    }
    format!("'{}'", word.replace('\'', "'\\''"))
}
