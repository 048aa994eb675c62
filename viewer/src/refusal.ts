/** What a user is told: one sentence. */
export class Refusal extends Error {}

/** A file of the page could not be fetched; another try may help. */
export class Unreachable extends Refusal {
  constructor(path: string) {
    super(`The file ${path} could not be fetched; check that the server of the page still runs.`);
  }
}

/** The user has cancelled it. */
export class Cancelled extends Refusal {
  constructor() {
    super("It was cancelled.");
  }
}
