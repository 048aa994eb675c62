/** Vite gives the text of a file whose name ends so. */
declare module "*.csv?raw" {
  const text: string;
  export default text;
}
