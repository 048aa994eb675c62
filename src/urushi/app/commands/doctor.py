"""`urushi doctor`: what this machine has, and what is wrong with it."""

from dataclasses import dataclass


@dataclass(frozen=True)
class Doctor:
    """Print what Urushi finds on this machine, and what is wrong with each.

    Python, Mitsuba, Dr.Jit, LLVM, the variants that run, GPU and the shipped weights. The exit code
    is 1 if something essential is wrong.

    Example: urushi doctor
    """

    def run(self) -> int:
        from urushi.app import doctor

        findings = doctor.examine()
        print(doctor.report(findings))
        return 1 if any(finding.essential and finding.problem for finding in findings) else 0
