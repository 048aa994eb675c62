/** What a user is told: one sentence. */
export class Refusal extends Error {}
